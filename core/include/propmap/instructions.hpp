// Which of the package's builds suits this processor; the system has to keep its registers, too.
#pragma once

namespace propmap {

inline const char* best_instructions() {
#ifdef __x86_64__
    __builtin_cpu_init();
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                    __builtin_cpu_supports("bmi2");
    const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    return v3 && v4 ? "x86-64-v4" : v3 ? "x86-64-v3" : "x86-64-v2";
#else
    return "generic";
#endif
}

}  // namespace propmap
