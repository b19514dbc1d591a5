// A rotor with any section law, and the derivatives of its loads.  The derivatives take longer to compile than all other
// functions of the module; slopes.cpp compiles them separately, while bind.cpp compiles.
#pragma once

#include <string>
#include <variant>

#include "propmap/laws.hpp"
#include "propmap/rotor.hpp"

namespace propmap {

template <class List> struct SolverOf;
template <template <class> class... LawOf> struct SolverOf<LawList<LawOf...>> {
    using type = std::variant<RotorSolver<LawOf>...>;
};
using AnySolver = SolverOf<Laws>::type;

// Names of the numbers of blade, flow, law and mount with respect to which loads can be differentiated.
std::vector<std::string> names_of(const AnySolver& solver);

// Write the derivatives (6, P) of the loads in the solution `s` with respect to P numbers, given by their indices in
// `names_of`.  In descent they require the solution `at_rest` for the same Omega.  Consecutive derivatives are `stride`
// elements apart.
void write_slopes(const AnySolver& solver, const Solution& s, const Solution& at_rest, const std::vector<std::size_t>& which,
                  double* to, std::size_t stride);

}  // namespace propmap
