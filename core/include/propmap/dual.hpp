// Dual numbers: a value with its derivatives along N directions, for forward-mode differentiation.
//
// The value is a double or Lanes.  Expressions may mix dual numbers with ordinary numbers, which are constants.
// Subexpressions without dual numbers are computed without derivatives, at no extra cost.
#pragma once

#include "elementary.hpp"

namespace propmap {

template <class V, int N> struct Dual {  // value and derivatives
    V v;
    V d[N];
};

template <class T> struct Traits {  // number of directions, and type of the value
    static constexpr int directions = 0;
    using Value = T;
};
template <class V, int N> struct Traits<Dual<V, N>> {
    static constexpr int directions = N;
    using Value = V;
};

template <class T> inline constexpr int directions_of = Traits<T>::directions;
template <class T> concept IsDual = (directions_of<T> > 0);
template <class T> using ValueOf = typename Traits<T>::Value;

template <class T> const auto& value(const T& x) {  // x without its derivatives
    if constexpr (IsDual<T>) return x.v;
    else return x;
}

// f(x) with its derivative `slope` at x.
template <class T, class V, class W> auto chain(const T& x, const V& f, const W& slope) {
    if constexpr (IsDual<T>) {
        Dual<V, directions_of<T>> r;
        r.v = f;
        for (int k = 0; k < directions_of<T>; ++k) r.d[k] = slope * x.d[k];
        return r;
    } else {
        return f;
    }
}

template <class A, class B> concept EitherDual = IsDual<A> || IsDual<B>;

// f(x, y) with its derivatives with respect to x and y.
template <class A, class B, class V, class X, class Y> auto chain(const A& x, const B& y, const V& f, const X& by_x, const Y& by_y) {
    if constexpr (IsDual<A> && IsDual<B>) {
        auto r = chain(x, f, by_x);
        for (int k = 0; k < directions_of<A>; ++k) r.d[k] += by_y * y.d[k];
        return r;
    } else if constexpr (IsDual<A>) {
        return chain(x, f, by_x);
    } else {
        return chain(y, f, by_y);
    }
}

// The derivatives of a sum are `one`; compilers remove the products with it.
template <class A, class B> requires EitherDual<A, B> auto operator+(const A& a, const B& b) {
    const auto total = value(a) + value(b);
    const auto one = broadcast_like(total, 1.0);
    return chain(a, b, total, one, one);
}
template <class A, class B> requires EitherDual<A, B> auto operator-(const A& a, const B& b) {
    const auto difference = value(a) - value(b);
    const auto one = broadcast_like(difference, 1.0);
    return chain(a, b, difference, one, -one);
}
template <class A, class B> requires EitherDual<A, B> auto operator*(const A& a, const B& b) {
    return chain(a, b, value(a) * value(b), value(b), value(a));
}
template <class A, class B> requires EitherDual<A, B> auto operator/(const A& a, const B& b) {
    const auto per = 1.0 / value(b);
    return a * chain(b, per, -per * per);
}

template <IsDual T> T operator-(const T& a) { return chain(a, -a.v, broadcast_like(a.v, -1.0)); }

template <class V, int N, class B> Dual<V, N>& operator+=(Dual<V, N>& a, const B& b) { return a = a + b; }

template <class M, class A, class B> requires EitherDual<A, B> auto select(M which, const A& a, const B& b) {
    constexpr int N = IsDual<A> ? directions_of<A> : directions_of<B>;
    using V = decltype(value(a) + value(b));
    const V none{};
    Dual<V, N> r;
    r.v = select(which, value(a) - none, value(b) - none);
    for (int k = 0; k < N; ++k) {
        if constexpr (!IsDual<B>) r.d[k] = select(which, a.d[k] - none, none);
        else if constexpr (!IsDual<A>) r.d[k] = select(which, none, b.d[k] - none);
        else r.d[k] = select(which, a.d[k] - none, b.d[k] - none);
    }
    return r;
}

template <class A, class B> requires EitherDual<A, B> auto minimum(const A& a, const B& b) {
    return select(value(a) < value(b), a, b);
}
template <class A, class B> requires EitherDual<A, B> auto maximum(const A& a, const B& b) {
    return select(value(a) > value(b), a, b);
}
template <IsDual T> T absolute(const T& x) {
    return chain(x, absolute(x.v), select(x.v < 0.0, broadcast_like(x.v, -1.0), broadcast_like(x.v, 1.0)));
}

template <IsDual T> auto square_root(const T& x) {
    const auto root = square_root(x.v);
    return chain(x, root, 0.5 / root);
}
template <IsDual T> auto logarithm(const T& x) { return chain(x, logarithm(x.v), 1.0 / x.v); }
template <IsDual T> auto power_of_two(const T& x) {
    auto p = power_of_two(x.v);
    return chain(x, p, 0.69314718055994530942 * p);
}
template <IsDual T> SineCosine<T> sine_cosine(const T& x) {
    auto both = sine_cosine(x.v);
    return {chain(x, both.sine, both.cosine), chain(x, both.cosine, -both.sine)};
}
template <IsDual T> T square(const T& x) { return chain(x, x.v * x.v, 2.0 * x.v); }
// Since cosine^2 + sine^2 = 1, the derivative of the angle is cosine d(sine) - sine d(cosine).
template <class A, class B> requires EitherDual<A, B> auto angle_of(const A& cosine, const B& sine) {
    auto turn = value(cosine) * sine - value(sine) * cosine;
    turn.v = angle_of(value(cosine), value(sine));
    return turn;
}

// An angle, stored as sine and cosine.  `change` has the value zero and the derivatives of the angle, so that sine and
// cosine need none.
template <class T> struct Angle {
    ValueOf<T> sine, cosine;
    T change;
};
template <class A, class B> auto operator-(const Angle<A>& a, const Angle<B>& b) {
    auto change = a.change - b.change;
    using C = decltype(change);
    if constexpr (IsDual<C>) change.v = ValueOf<C>{};
    else change = C{};
    return Angle<std::remove_const_t<decltype(change)>>{a.sine * b.cosine - a.cosine * b.sine,
                                                       a.cosine * b.cosine + a.sine * b.sine, change};
}
template <class T> T sine(const Angle<T>& a) { return chain(a.change, a.sine, a.cosine); }
template <class T> T cosine(const Angle<T>& a) { return chain(a.change, a.cosine, -a.sine); }
template <class T> T radians(const Angle<T>& a) {
    return chain(a.change, angle_of(a.cosine, a.sine), broadcast_like(a.cosine, 1.0));
}
template <class T> auto angle_from(const T& x) {
    const auto both = sine_cosine(value(x));
    return Angle<T>{both.sine, both.cosine, x - value(x)};
}

}  // namespace propmap
