"""The core's elementary functions, beside the mathematics library's."""

from __future__ import annotations

import subprocess
from pathlib import Path

from propmap.rotor import include_folder
from tests.export.needed import program
from tests.export.test_cpp_rotor import FAST, FLAGS

PROGRAM = r"""
#include <cstdio>
#include <propmap/elementary.hpp>
using namespace propmap;

template <class Ours, class Theirs>
void compare(const char* name, double low, double high, bool evenly, Ours ours, Theirs theirs) {
    double worst = 0.0;
    const int count = 400000;
    for (int k = 0; k < count; k += width) {
        const Lanes x = each_lane([&](int j) {
            const double t = low + (high - low) * (k + j) / (count - 1.0);
            return evenly ? t : std::pow(10.0, t);
        });
        const Lanes found = ours(x);
        for (int j = 0; j < width; ++j)
            if (const double e = std::fabs(found[j] / theirs(x[j]) - 1.0); !(e <= worst)) worst = e;
    }
    std::printf("%s %.3g\n", name, worst);
}

int main() {
    const auto power = [](Lanes x) { return power_of_two(x); };
    compare("power", -100.0, 100.0, true, power, [](double x) { return std::exp2(x); });
    const auto log = [](Lanes x) { return logarithm(x); };
    compare("log", -300.0, 300.0, false, log, [](double x) { return std::log(x); });
    const auto sine = [](Lanes x) { return sine_cosine(x).sine; };
    compare("sine", 1e-6, 3.1, true, sine, [](double x) { return std::sin(x); });
    const auto angle = [](Lanes x) {
        const auto cosine = each_lane([&](int k) { return std::cos(x[k]); });
        return angle_of(cosine, each_lane([&](int k) { return std::sin(x[k]); }));
    };
    compare("angle", 1e-3, 3.14, true, angle, [](double x) { return x; });
}
"""


LIMITS = {"power": 3e-14, "log": 2e-15, "sine": 1e-14, "angle": 1e-12}


def test_relative_errors_are_those_of_rounding_or_as_the_header_says(tmp_path: Path) -> None:
    (tmp_path / "errors.cpp").write_text(PROGRAM, encoding="utf-8")
    headers = ["-I", include_folder()]
    build = [program("c++"), *FLAGS, *FAST, *headers, "errors.cpp", "-o", "errors"]
    subprocess.run(build, cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "errors"], check=True, capture_output=True, text=True)
    errors = {name: float(error) for name, error in map(str.split, done.stdout.splitlines())}
    assert errors.keys() == LIMITS.keys()
    assert {name for name, error in errors.items() if not error <= LIMITS[name]} == set()
