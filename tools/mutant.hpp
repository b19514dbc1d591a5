// Mutants that are selected at run time, for tools/mutation_trial.py: K is the number of a mutant.
#pragma once

#include <cstdlib>
#include <type_traits>

#define MUTANT_INLINE [[gnu::always_inline]] inline

namespace mutant {

inline const int active = std::atoi(std::getenv("PROPMAP_MUTANT"));
inline int reached[1000];

// Whether mutant K is the active one.
template <int K> MUTANT_INLINE bool on() {
    reached[K - 900000] = 1;
    return __builtin_expect(active == K, 0);
}
template <int K, class T> MUTANT_INLINE T value(T a, T b) { return on<K>() ? b : a; }
template <int K, class F, class G> MUTANT_INLINE auto pick(F f, G g) {
    return [=](auto... a) { return on<K>() ? g(a...) : f(a...); };
}
MUTANT_INLINE bool negated(bool x) { return !x; }
template <class T> MUTANT_INLINE T negated(const T& x) { return ~x; }

// `condition == Flip<K>{}` is the condition, or its opposite.
template <int K> struct Flip {};
template <class A, int K> MUTANT_INLINE auto operator==(A a, Flip<K>) {
    if constexpr (std::is_convertible_v<A, bool>) return bool(a) != on<K>();
    else return on<K>() ? negated(a) : a;
}

// `Sign<K>{} * a` is -a, or a.
template <int K> struct Sign {};
template <int K, class A> MUTANT_INLINE auto operator*(Sign<K>, A a) {
    using R = std::remove_cvref_t<decltype(-a)>;
    return on<K>() ? R(a) : R(-a);
}

// `a + PlusMinus<K>{} + b` is a + b, or a - b, with the precedence of a + b.
#define MUTANT_INFIX(NAME, OP, MUTATED)                                                            \
    template <int K> struct NAME {};                                                               \
    template <int K, class A> struct NAME##Left {                                                  \
        A a;                                                                                       \
    };                                                                                             \
    template <class A, int K> MUTANT_INLINE NAME##Left<K, A> operator OP(A a, NAME<K>) {           \
        return {a};                                                                                \
    }                                                                                              \
    template <int K, class A, class B>                                                             \
    MUTANT_INLINE auto operator OP(NAME##Left<K, A> left, B b) {                                   \
        const A a = left.a;                                                                        \
        using R = std::remove_cvref_t<decltype(a OP b)>;                                           \
        return on<K>() ? R(MUTATED) : R(a OP b);                                                   \
    }
MUTANT_INFIX(PlusMinus, +, a - b)
MUTANT_INFIX(PlusDrop, +, a - R{})
MUTANT_INFIX(MinusPlus, -, a + b)
MUTANT_INFIX(MinusDrop, -, a - R{})
MUTANT_INFIX(TimesOver, *, a / b)
MUTANT_INFIX(TimesDrop, *, a - R{})
MUTANT_INFIX(OverTimes, /, a * b)
MUTANT_INFIX(OverDrop, /, a - R{})
MUTANT_INFIX(LessEqual, <, a <= b)
MUTANT_INFIX(NotLess, <, negated(a < b))
MUTANT_INFIX(MoreEqual, >, a >= b)
MUTANT_INFIX(NotMore, >, negated(a > b))
MUTANT_INFIX(EqualLess, <=, a < b)
MUTANT_INFIX(NotLessEqual, <=, negated(a <= b))
MUTANT_INFIX(EqualMore, >=, a > b)
MUTANT_INFIX(NotMoreEqual, >=, negated(a >= b))
MUTANT_INFIX(NotEqual, ==, negated(a == b))
MUTANT_INFIX(Equal, !=, negated(a != b))

}  // namespace mutant

// For Python: which mutants' code was executed.
extern "C" [[gnu::visibility("default"), gnu::used]] inline int* mutants_reached() {
    return mutant::reached;
}
