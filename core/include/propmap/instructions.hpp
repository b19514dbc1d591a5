// Choice of the build for this processor, from its instruction sets and the registers that the operating system saves.
// (__builtin_cpu_supports finds nothing in code that Zig has compiled.)
#pragma once

#include <initializer_list>

#ifdef __x86_64__
#include <cpuid.h>
#endif

namespace propmap {

inline const char* best_instructions() {
#ifdef __x86_64__
    const auto all = [](unsigned in, std::initializer_list<int> bits) {
        for (int bit : bits) if (!(in >> bit & 1)) return false;
        return true;
    };
    unsigned a, b, basic = 0, more = 0, extended = 0, kept = 0, d;
    __get_cpuid(1, &a, &b, &basic, &d);
    __get_cpuid_count(7, 0, &a, &more, &b, &d);
    __get_cpuid(0x80000001, &a, &b, &extended, &d);
    if (all(basic, {27})) asm("xgetbv" : "=a"(kept), "=d"(d) : "c"(0));
    // FMA, MOVBE, AVX, F16C; BMI1, AVX2, BMI2; LZCNT; saved registers of SSE and AVX.
    if (!(all(basic, {12, 22, 28, 29}) && all(more, {3, 5, 8}) && all(extended, {5}) && all(kept, {1, 2}))) return "x86-64-v2";
    // AVX-512 F, DQ, CD, BW, VL; saved mask registers and registers of AVX-512.
    return all(more, {16, 17, 28, 30, 31}) && all(kept, {5, 6, 7}) ? "x86-64-v4" : "x86-64-v3";
#else
    return "generic";
#endif
}

}  // namespace propmap
