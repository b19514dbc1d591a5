"""The system of examples/gz, compiled against a stand-in for gz-sim, applies propmap's loads."""

from __future__ import annotations

import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import propmap as pm
from propmap.export import export_rotor
from propmap.rotor import include_folder

from .needed import program
from .test_cpp_rotor import QUICKLY_COMPILED

pytestmark = pytest.mark.slow

EXAMPLE = Path(__file__).parents[2] / "examples" / "gz"
STUB = Path(__file__).with_name("gz_stub.hpp")

MAIN = """
#include "propmap_rotors.cpp"
#include <cstdio>

int main() {
    namespace sim = gz::sim;
    char name[64], value[64];
    auto sdf = std::make_shared<sdf::Element>();
    auto add = std::make_shared<sdf::Element>();
    sim::EntityComponentManager ecm;
    sim::EventManager events;
    int rotors = 0;
    while (std::scanf("%63s %63s", name, value) == 2 && std::string(name) != "steps") {
        const std::string key = name;
        const bool shared = key == "bodyLink" || key == "rotorVelocitySlowdownSim";
        (shared ? sdf : add)->values[key] = value;
        if (key != "turningDirection") continue;  // the last of a rotor
        add->parent = sdf.get();
        sdf->children.push_back(add);
        ecm.names[add->values["jointName"]] = 10 + rotors;
        ecm.names[add->values["linkName"]] = 20 + rotors;
        ecm.states[10 + rotors], ecm.states[20 + rotors];
        ++rotors;
        add = std::make_shared<sdf::Element>();
    }
    ecm.names[sdf->values["bodyLink"]] = 1, ecm.states[1];
    gz::math::Quaterniond turned;
    double w[3], dt, omega, v[3];
    for (auto& row : turned.rows)
        if (std::scanf("%lf %lf %lf", &row[0], &row[1], &row[2]) != 3) return 1;
    if (std::scanf("%lf %lf %lf %lf", &w[0], &w[1], &w[2], &dt) != 4) return 1;
    ecm.wind = sim::components::WorldLinearVelocity{{w[0], w[1], w[2]}};
    Plugin plugin;
    plugin.Configure(5, sdf, ecm, events);
    const sim::UpdateInfo info{std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(dt)), false};
    while (std::scanf("%lf %lf %lf %lf", &omega, &v[0], &v[1], &v[2]) == 4) {
        for (auto& [id, state] : ecm.states) {
            state.pose.q = turned, state.velocity = {v[0], v[1], v[2]}, state.turning = omega;
            state.force = {}, state.torque = {};
            if (id >= 20) {  // the links of the rotors turn with their joints
                const double c = std::cos(0.3 * double(id)), s = std::sin(0.3 * double(id));
                for (auto& row : state.pose.q.rows)
                    row = {c * row[0] + s * row[1], c * row[1] - s * row[0], row[2]};
            }
        }
        plugin.PreUpdate(info, ecm);
        const auto print = [](const gz::math::Vector3d& a) {
            std::printf("%.17g %.17g %.17g ", a.X(), a.Y(), a.Z());
        };
        for (int k = 0; k < rotors; ++k) print(ecm.states[20 + k].force);
        print(ecm.states[1].torque);
        std::printf("\\n");
    }
}
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that runs the system."""
    folder = tmp_path_factory.mktemp("gz")
    export_rotor(pm.Rotor(pm.catalogue_model("apc-8x6e")), "cpp", folder)
    shutil.copy(EXAMPLE / "propmap_rotors.cpp", folder)
    shutil.copy(STUB, folder)
    included = re.findall("#include <((?:gz|sdf)/.*)>", (folder / "propmap_rotors.cpp").read_text())
    assert "gz/sim/System.hh" in included
    for name in included:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text('#include "gz_stub.hpp"\n')
    (folder / "main.cpp").write_text(MAIN)
    headers = ["-I", folder, "-isystem", include_folder()]
    command = [program("c++"), *QUICKLY_COMPILED, "-Wno-psabi", *headers, "main.cpp", "-o", "main"]
    done = subprocess.run(command, cwd=folder, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return folder / "main"


def snippet() -> ET.Element:
    """The <plugin> of the example's README."""
    text = (EXAMPLE / "README.md").read_text()
    (found,) = re.findall(r"```xml\n(.*?)```", text, re.S)
    return ET.fromstring(found)


def settings() -> list[str]:
    """The elements of the snippet, one a line, as the stand-in reads them."""
    return [f"{each.tag} {each.text}" for each in snippet().iter() if (each.text or "").strip()]


def test_the_system_applies_the_loads_with_dynamic_inflow(built: Path) -> None:
    """From rest, then with another speed and direction, on a tilted vehicle in wind."""
    turned = Rotation.from_euler("xyz", [0.2, -0.3, 0.7])
    wind, dt = np.array([1.0, -2.0, 0.5]), 0.004
    omega = np.repeat([600.0, 700.0], 15)
    through = np.repeat([[4.0, 2.0, 1.0], [-1.0, 6.0, -0.5]], 15, axis=0)  # in the body's frame
    through[:3] = [0.0, 0.0, 2.0]
    world = turned.apply(through) + wind
    rows = [turned.as_matrix().ravel(), [*wind, dt]]
    # The joints turn at a tenth of the rotors' speed.
    rows += [[w / 10.0, *v] for w, v in zip(omega, world, strict=True)]
    lines = [*settings(), "steps follow", *(" ".join(map(repr, map(float, row))) for row in rows)]
    done = subprocess.run([built], input="\n".join(lines), text=True, capture_output=True)
    assert (done.returncode, done.stderr) == (0, "")
    found = np.array([line.split() for line in done.stdout.splitlines()], float)

    rotor = pm.Rotor(pm.catalogue_model("apc-8x6e"))
    spins = [each.text or "" for each in snippet().iter("turningDirection")]
    assert sorted(spins) == ["ccw", "ccw", "cw", "cw"]
    moments = np.zeros((omega.size, 3))
    for k, spin in enumerate(spins):
        dynamic = pm.DynamicInflow(rotor, spin=spin)
        state = np.zeros(dynamic.size)
        for n, (w, v) in enumerate(zip(omega, through, strict=True)):
            wrench, state = dynamic.advance(state, dt, w, v)
            mine = found[n, 3 * k : 3 * k + 3]
            np.testing.assert_allclose(mine, turned.apply(wrench.force), atol=1e-8)
            moments[n] += turned.apply(wrench.moment)
    np.testing.assert_allclose(found[:, -3:], moments, atol=1e-8)
    # The inflow lags: after the jump of the rotor speed, the thrust decreases to the static one.
    first, last = np.linalg.norm(found[[15, -1], :3], axis=1)
    assert first > 1.03 * last
    static = rotor.wrench(omega[-1], through[-1], spins[0]).force
    assert last == pytest.approx(np.linalg.norm(static), rel=0.02)


def test_an_unknown_turning_direction_is_an_error_without_loads(built: Path) -> None:
    lines = [line.replace("turningDirection cw", "turningDirection left") for line in settings()]
    rows = [*np.eye(3), [0.0, 0.0, 0.0, 0.004], [60.0, 0.0, 0.0, 0.0]]
    lines += ["steps follow", *(" ".join(map(repr, map(float, row))) for row in rows)]
    done = subprocess.run([built], input="\n".join(lines), text=True, capture_output=True)
    assert "check bodyLink, and jointName" in done.stderr
    assert set(done.stdout.split()) == {"0"}
