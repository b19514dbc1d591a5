// All section laws that a rotor may have.
#pragma once

#include "section.hpp"

namespace propmap {

template <template <class> class... LawOf> struct LawList {};
using Laws = LawList<BlendedLaw, GrowingLaw, TabulatedLaw>;

}  // namespace propmap
