// Vectors of numbers, in lanes, and the elementary functions of a blade element in a form that vectorizes.
//
// A lane is one radius of a blade, or one trial inflow at one radius.  The compiler's vector extensions do the
// arithmetic.  A mathematics library would compute one lane at a time.  Except for the square root, an instruction of the
// processor, the functions are therefore polynomials here.  Each lane is computed by itself: no result depends on `width`,
// the number of lanes.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

// Vectors are passed within one program only: differences between calling conventions do not matter.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace propmap {

#if defined(__AVX512F__)
inline constexpr int width = 8;
#else
inline constexpr int width = 4;
#endif

using Lanes = double __attribute__((vector_size(8 * width)));
using Mask = decltype(Lanes{} < Lanes{});  // result of a comparison; compilers differ in its 64-bit type

inline constexpr double pi = 3.14159265358979323846;

inline Lanes broadcast(double x) { return x - Lanes{}; }  // x in all lanes

// Lanes with f(k) in lane k.
template <class F> Lanes each_lane(F f) {
    Lanes r{};
    for (int k = 0; k < width; ++k) r[k] = f(k);
    return r;
}

inline double broadcast_like(double, double x) { return x; }  // x as wide as the first argument
inline Lanes broadcast_like(Lanes, double x) { return broadcast(x); }

inline double select(bool which, double a, double b) { return which ? a : b; }
inline Lanes select(Mask which, Lanes a, Lanes b) { return which ? a : b; }

inline bool any(Mask m) {
    std::int64_t r = 0;
    for (int k = 0; k < width; ++k) r |= m[k];
    return r != 0;
}

inline double sum(Lanes x) {  // over all lanes
    double total = 0.0;
    for (int k = 0; k < width; ++k) total += x[k];
    return total;
}

inline double absolute(double x) { return std::fabs(x); }
inline Lanes absolute(Lanes x) { return std::bit_cast<Lanes>(std::bit_cast<Mask>(x) & 0x7fffffffffffffff); }

inline double minimum(double a, double b) { return a < b ? a : b; }
inline double maximum(double a, double b) { return a > b ? a : b; }
inline Lanes minimum(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes maximum(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes minimum(Lanes a, double b) { return minimum(a, broadcast(b)); }
inline Lanes maximum(Lanes a, double b) { return maximum(a, broadcast(b)); }

inline double square(double x) { return x * x; }
inline Lanes square(Lanes x) { return x * x; }

namespace detail {

// Estrin's scheme: pairs of terms are computed independently of each other.
template <std::size_t N, class T> T polynomial(const double (&c)[N], T x) {
    T part[(N + 1) / 2];
    for (std::size_t k = 0; k < N / 2; ++k) part[k] = c[2 * k] + c[2 * k + 1] * x;
    if constexpr (N % 2) part[N / 2] = c[N - 1] + 0.0 * x;
    T power = x * x;
    for (std::size_t n = (N + 1) / 2; n > 1; n = (n + 1) / 2, power = power * power) {
        for (std::size_t k = 0; k < n / 2; ++k) part[k] = part[2 * k] + part[2 * k + 1] * power;
        if (n % 2) part[n / 2] = part[n - 1];
    }
    return part[0];
}

// 2^x for |x| <= 100: a polynomial of the fraction (error 2e-14), and the whole part in the bits of the exponent.
inline constexpr double power_series[] = {
    1.000000000000013487,    0.693147180559946159,    0.2402265069564033974,   0.05550410866465167201,
    0.009618129193934313355, 0.001333355820079459264, 0.0001540343375125100892, 0.0000152526729248507364,
    1.325964524488711024e-6, 1.020590541376559579e-7};

template <class T, class I> T power_of_two(T x) {
    // Adding this large number rounds x to a whole number, which is then in the last bits of the sum.
    const double shift = 1.5 * 4503599627370496.0;
    T large = x + shift;
    T whole = large - shift;
    T power = polynomial(power_series, x - whole);
    return std::bit_cast<T>(std::bit_cast<I>(power) + (std::bit_cast<I>(large) << 52));
}

// An angle divided by its sine: a polynomial of 2 cos - 1, for cosines from 0 to 1 (error 4e-13).
inline constexpr double angle_series[] = {
    1.209199576155869516,     -0.263600141281195541,     0.06973319208731127941,  -0.01983714693391221358,
    0.005861628237479900151,  -0.001772928222006002394,  0.00054477984047757279,  -0.0001693118448556759471,
    0.00005305101910057807332, -0.00001674178826845915375, 5.36162542907487025e-6, -1.708989102970234871e-6,
    4.880137059354355897e-7,  -1.564219934032609264e-7,  8.6417766281388885e-8,   -2.791601410982174177e-8};

}  // namespace detail

inline double power_of_two(double x) { return detail::power_of_two<double, std::int64_t>(x); }
inline Lanes power_of_two(Lanes x) { return detail::power_of_two<Lanes, Mask>(x); }

// ln(x) for x > 0: ln(m) + n ln(2) with x = 2^n m and m between sqrt(1/2) and sqrt(2).  The series of ln(m) in powers of
// s = (m - 1)/(m + 1) errs by less than rounding.  For x <= 0, -infinity.
inline Lanes logarithm(Lanes x) {
    constexpr double series[] = {2.0, 2.0 / 3, 2.0 / 5, 2.0 / 7, 2.0 / 9, 2.0 / 11, 2.0 / 13, 2.0 / 15, 2.0 / 17, 2.0 / 19};
    const Mask bits = std::bit_cast<Mask>(x > 0.0 ? x : broadcast(1.0)), n = (bits - 0x3fe6a09e667f3bcd) >> 52;
    const Lanes m = std::bit_cast<Lanes>(bits - (n << 52)), s = (m - 1.0) / (m + 1.0);
    const Lanes whole = std::bit_cast<Lanes>(n + 0x4338000000000000) - 1.5 * 4503599627370496.0;  // n, converted to double
    const Lanes found = whole * 0.69314718055994530942 + s * detail::polynomial(series, Lanes(s * s));
    return x > 0.0 ? found : x - INFINITY;
}

// Square roots and quotients take longer than products, but the processor computes them at the same time as products.
// (Newton's iterations in their place, with products alone, took an eighth more time for a step of dynamic inflow.)
inline double square_root(double x) { return std::sqrt(x); }
inline Lanes square_root(Lanes x) { return each_lane([&](int k) { return std::sqrt(x[k]); }); }

// Angle [rad] in (-pi, pi] with this cosine and sine.
inline Lanes angle_of(Lanes cosine, Lanes sine) {
    const Lanes near = sine * detail::polynomial(detail::angle_series, Lanes(2.0 * absolute(cosine) - 1.0));
    const Lanes turned = (sine < 0.0 ? broadcast(-pi) : broadcast(pi)) - near;
    return cosine < 0.0 ? turned : near;
}

namespace detail {

// Taylor series of cos(x) and sin(x)/x in powers of x^2.
struct TurnSeries {
    double cosine[11], sine[11];
    constexpr TurnSeries() : cosine{1.0}, sine{1.0} {
        for (int k = 1; k <= 10; ++k) {
            cosine[k] = cosine[k - 1] / -((2.0 * k - 1.0) * (2.0 * k));
            sine[k] = sine[k - 1] / -((2.0 * k) * (2.0 * k + 1.0));
        }
    }
};
inline constexpr TurnSeries turn_series;

}  // namespace detail

template <class T> struct SineCosine { T sine, cosine; };

// For |x| <= pi, by the series at half the angle; error 3e-16.
inline SineCosine<Lanes> sine_cosine(Lanes x) {
    const Lanes half = 0.5 * x, z = half * half;
    const Lanes sine = half * detail::polynomial(detail::turn_series.sine, z);
    const Lanes cosine = detail::polynomial(detail::turn_series.cosine, z);
    return {2.0 * sine * cosine, 1.0 - 2.0 * sine * sine};
}

}  // namespace propmap
