#include "slopes.hpp"

#include "propmap/derivatives.hpp"

namespace propmap {

namespace {

// The numbers of blade, flow, law and mount with their names.
template <class S, template <class> class LawOf>
std::vector<std::pair<const char*, S*>> numbers_of(Rotor<S, LawOf>& rotor, Flow<S>& flow) {
    std::vector<std::pair<const char*, S*>> all{{"chord_scale", &rotor.change.chord_scale},
                                                {"twist_offset", &rotor.change.twist_offset},
                                                {"untwist", &rotor.change.untwist}};
    flow.each_variable([&](const char* name, S& number) { all.emplace_back(name, &number); });
    rotor.law.each_number([&](const char* name, S& number) { all.emplace_back(name, &number); });
    if (rotor.installed) all.emplace_back("drag_factor", &rotor.drag_factor), all.emplace_back("mount_area", &rotor.mount_area);
    return all;
}

// Derivatives of the loads with respect to `count` numbers, at most `together`.
template <template <class> class LawOf>
Loads<Slope> slopes_by(const RotorSolver<LawOf>& solver, const Solution& s, const Solution& at_rest,
                       const std::size_t* which, std::size_t count) {
    Rotor<double, LawOf> from = solver.rotor();
    Flow<double> from_flow = s.flow;
    Rotor<Slope, LawOf> rotor;
    Flow<Slope> flow;
    static_cast<RotorSettings&>(rotor) = from;
    static_cast<LiftCorrections&>(rotor.law) = from.law;
    flow.v_hover = {from_flow.v_hover, {}};
    const auto old = numbers_of(from, from_flow);
    const auto now = numbers_of(rotor, flow);
    for (std::size_t k = 0; k < now.size(); ++k) *now[k].second = {*old[k].second, {}};
    for (std::size_t d = 0; d < count; ++d) now[which[d]].second->d[d] = 1.0;
    rotor.law.copy_fixed(from.law);
    return load_slopes(solver, s, at_rest, rotor, flow);
}

}  // namespace

std::vector<std::string> names_of(const AnySolver& solver) {
    return std::visit([](const auto& of) {
        auto rotor = of.rotor();
        Flow<double> flow{};
        std::vector<std::string> names;
        for (const auto& [name, number] : numbers_of(rotor, flow)) names.emplace_back(name);
        return names;
    }, solver);
}

void write_slopes(const AnySolver& any, const Solution& s, const Solution& at_rest, const std::vector<std::size_t>& which,
                  double* to, std::size_t stride) {
    const auto keep = [&](int load, std::size_t d, double slope) {
        const bool lost = s.result.status == Status::not_converged;
        to[(load * which.size() + d) * stride] = lost ? std::nan("") : slope;
    };
    std::visit([&](const auto& solver) {
        auto rotor = solver.rotor();
        Flow<double> flow = s.flow;
        const auto numbers = numbers_of(rotor, flow);
        std::vector<std::size_t> nonlinear, place;  // all numbers except the two named below; their indices in `which`
        // Drag is linear in `drag_factor` and `mount_area`.  No other load depends on them, nor does the inflow.
        rotor.mount_area = 1.0;
        const double by_area = rotor.density * mount_drag(rotor, s.flow, s.result.mean_inflow);
        for (std::size_t d = 0; d < which.size(); ++d) {
            const double* number = numbers[which[d]].second;
            const double by_drag = number == &rotor.drag_factor ? s.result.blade_drag : by_area;
            if (number != &rotor.drag_factor && number != &rotor.mount_area) nonlinear.push_back(which[d]), place.push_back(d);
            else for (int j = 0; j < Loads<double>::count; ++j) keep(j, d, j == 1 ? by_drag : 0.0);
        }
        for (std::size_t first = 0; first < nonlinear.size(); first += together) {
            const std::size_t count = std::min<std::size_t>(together, nonlinear.size() - first);
            const auto found = slopes_by(solver, s, at_rest, &nonlinear[first], count);
            for (int j = 0; j < Loads<double>::count; ++j)
                for (std::size_t d = 0; d < count; ++d) keep(j, place[first + d], found.begin()[j].d[d]);
        }
    }, any);
}

}  // namespace propmap
