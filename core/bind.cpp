// The Python module of the core.  Rotors are passed as dictionaries of numbers; operating points and loads as arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#ifdef __x86_64__
#include <cpuid.h>
#endif

#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <thread>

#include "propmap/disk_field.hpp"
#include "propmap/dynamic_inflow.hpp"
#include "propmap/interaction.hpp"
#include "propmap/vehicle.hpp"
#include "slopes.hpp"

namespace nb = nanobind;
using namespace propmap;

namespace {  // CMakeLists.txt defines PROPMAP_MODULE and PROPMAP_INSTRUCTIONS

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<nb::numpy, double>;
using Shape = std::vector<std::size_t>;
// Operating points: a row for each variable of `Flow`, a column for each point.
using Points = nb::ndarray<const double, nb::shape<Flow<double>::variables, -1>, nb::c_contig, nb::device::cpu>;

// Intervals of a blade (`BladeShape`), one per row.
using Intervals = nb::ndarray<const double, nb::shape<-1, 9>, nb::c_contig, nb::device::cpu>;
// Vectors (N, 3), one per row.
using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
Vector3 vector(const double* from) { return {from[0], from[1], from[2]}; }
double* keep(const Vector3& v, double* to) { return std::copy(v.begin(), v.end(), to); }
constexpr Vector3 up{0.0, 0.0, 1.0};  // direction of the thrust in the rotor frame

// Raise propmap.errors.InputError.
[[noreturn]] void refuse(const std::string& found, const std::string& remedy = "") {
    const nb::object error = nb::module_::import_("propmap.errors").attr("InputError");
    PyErr_SetObject(error.ptr(), error(found, remedy).ptr());
    throw nb::python_error();
}
void expect(const char* name, std::size_t found, std::size_t wanted, bool at_least = false) {  // check a length
    if (found == wanted || (at_least && found > wanted)) return;
    refuse("the array " + std::string(name) + " has the length " + std::to_string(found),
           "give " + std::string(at_least ? "at least " : "") + std::to_string(wanted) + " elements");
}

Flow<double> point(const Points& points, std::size_t k) {  // point k
    Flow<double> flow{};
    const double* row = points.data();
    flow.each_variable([&](const char*, double& number) { number = row[k], row += points.shape(1); });
    return flow;
}

std::vector<double> array_of(const nb::handle& from) {  // a copy of the array
    const auto v = nb::cast<Vector>(from);
    return {v.data(), v.data() + v.size()};
}

// Numbers and arrays by name, from a dictionary.
struct Source {
    nb::dict from;
    bool has(const char* name) const { return from.contains(name); }
    double number(const char* name) const { return nb::cast<double>(from[name]); }
    double number(const char* name, double otherwise) const { return has(name) ? number(name) : otherwise; }
    std::vector<double> numbers(const char* name, std::size_t size, bool at_least = false) const {
        auto found = array_of(from[name]);
        expect(name, found.size(), size, at_least);
        return found;
    }
    static void check(bool good, const char* fault) { good ? void() : refuse(fault); }
};

Numbers make_array(Shape shape, double*& data, std::size_t last = 0) {  // zeros; `last` > 0 adds an axis of this length
    if (last > 0) shape.push_back(last);
    std::size_t size = 1;
    for (std::size_t n : shape) size *= n;
    auto* memory = new double[std::max<std::size_t>(size, 1)]();
    data = memory;
    return Numbers(memory, shape.size(), shape.data(),
                   nb::capsule(memory, [](void* p) noexcept { delete[] static_cast<double*>(p); }));
}

// An array (rows, N) whose column k is `one(k)`.
template <class One> Numbers columns(std::size_t n, One one) {
    double* to;
    constexpr std::size_t rows = std::tuple_size_v<decltype(one(0))>;
    auto array = make_array({rows, n}, to);
    for (std::size_t k = 0; k < n; ++k) {
        const auto found = one(k);
        for (std::size_t j = 0; j < rows; ++j) to[j * n + k] = found[j];
    }
    return array;
}

// Two arrays (..., 3), whose vectors k are the pair `one(k)`.
template <class One> nb::tuple vector_pairs(const Shape& shape, One one) {
    double *first, *second;
    auto firsts = make_array(shape, first, 3), seconds = make_array(shape, second, 3);
    for (std::size_t k = 0; k < firsts.size() / 3; ++k) {
        const auto [a, b] = one(k);
        first = keep(a, first), second = keep(b, second);
    }
    return nb::make_tuple(firsts, seconds);
}

// An argument of a call in Python: a float or an array.  If `each` > 0, the last axis contains `each` numbers per point.
// Points broadcast as in NumPy.  `...` is read as zero.
class Argument {
  public:
    Argument(const char* name, nb::handle from, std::size_t each = 0, bool negative = true)
        : name_(name), from_(from), each_(each) {
        if (!given()) return;
        static const nb::handle array_type = nb::object(nb::module_::import_("numpy").attr("ndarray")).release();
        static const nb::handle as_array = nb::object(nb::module_::import_("numpy").attr("asarray")).release();
        nb::object array = nb::borrow(from);
        try {
            if (nb::isinstance<nb::list>(from) || nb::isinstance<nb::tuple>(from)) array = as_array(from);
        } catch (nb::python_error&) {}  // `numbers` below explains the fault
        if (PyFloat_Check(from.ptr())) number_ = PyFloat_AsDouble(from.ptr());
        else if (!array.type().is(array_type) || !nb::try_cast(array, array_, false)) number_ = NAN;
        const auto good = [&](double x) { return std::isfinite(x) && (negative || x >= 0.0); };
        const double* first = array_.is_valid() ? array_.data() : &number_;
        if (!std::all_of(first, first + (array_.is_valid() ? array_.size() : 1), good)) {
            const nb::object converted = nb::module_::import_("propmap.operating_points").attr("numbers");
            array_ = nb::cast<Array>(converted(name, from, negative));
        }
        if (each > 0 && (!array_.is_valid() || array_.ndim() == 0 || array_.shape(axes()) != each))
            refuse(text() + ": its last axis must have " + std::to_string(each) + " values");
    }
    bool given() const { return from_.ptr() != Py_Ellipsis; }

    // The broadcast shape of the points of all arguments.
    static Shape shape_of(std::initializer_list<const Argument*> all) {
        Shape shape;
        for (const Argument* a : all) shape.resize(std::max(shape.size(), a->axes()), 1);
        for (const Argument* a : all)
            for (std::size_t d = 0; d < a->axes(); ++d) {
                std::size_t& n = shape[shape.size() - a->axes() + d];
                if (n == 1) n = a->array_.shape(d);
                else if (a->array_.shape(d) != 1 && a->array_.shape(d) != n) {
                    std::string found;
                    for (const Argument* b : all)
                        if (b->given()) found += (found.empty() ? "" : ", ") + b->text();
                    refuse("shapes cannot be broadcast together: " + found);
                }
            }
        return shape;
    }

    const double* at(std::size_t k, const Shape& shape) const {  // the numbers of point k
        std::size_t place = 0, step = std::max<std::size_t>(each_, 1);
        for (std::size_t d = axes(), n = shape.size(); d-- > 0; step *= array_.shape(d), k /= shape[n])
            if (--n; array_.shape(d) > 1) place += k % shape[n] * step;
        return (array_.is_valid() ? array_.data() : &number_) + place;
    }

  private:
    std::size_t axes() const { return array_.is_valid() ? array_.ndim() - (each_ > 0) : 0; }
    std::string text() const {  // name and shape
        const nb::object shape = nb::module_::import_("numpy").attr("shape")(from_);
        return std::string(name_) + " has shape " + nb::cast<std::string>(nb::str(shape));
    }

    const char* name_;
    nb::handle from_;
    std::size_t each_;
    double number_ = 0.0;
    Array array_;
};

// Call `one(k)` for all k below `count`, on up to `threads` threads, and stop at a signal such as Ctrl-C.
// No result depends on the number of threads.  Threads end with the call, so that a process may fork between calls.
void for_each_point(std::size_t count, int threads, const std::function<void(std::size_t)>& one) {
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stop{false};
    const std::size_t chunk = std::clamp<std::size_t>(count / (8 * std::size_t(std::max(threads, 1))), 4, 16);
    const auto work = [&](bool listens) {
        auto last = std::chrono::steady_clock::now();
        for (std::size_t first; !stop && (first = next.fetch_add(chunk)) < count;) {
            for (std::size_t k = first; k < std::min(first + chunk, count) && !stop; ++k) one(k);
            if (!listens || std::chrono::steady_clock::now() - last <= std::chrono::milliseconds(50)) continue;
            const nb::gil_scoped_acquire held;
            if (PyErr_CheckSignals() != 0) stop = true;
            last = std::chrono::steady_clock::now();
        }
    };
    {
        const nb::gil_scoped_release free;
        std::vector<std::thread> others;
        for (std::size_t t = 1; t < std::min<std::size_t>(std::max(threads, 1), (count + 31) / 32); ++t) others.emplace_back(work, false);
        work(true);
        for (auto& t : others) t.join();
    }
    if (stop) throw nb::python_error();
}

template <class List> struct Variants;  // types over all section laws
template <template <class> class... LawOf> struct Variants<LawList<LawOf...>> {
    using Law = std::variant<LawOf<double>...>;
    using Motion = std::variant<std::monostate, DynamicInflow<LawOf>...>;

    static Law read(const Source& from) {  // the law of this kind
        const auto kind = nb::cast<std::string>(from.from["kind"]);
        Law law;
        const auto try_one = [&]<class One>(One one) {
            if (kind != One::kind) return;
            one.each_number([&](const char* name, double& value) { value = from.number(name); });
            one.read_fixed(from);
            law = one;
        };
        (try_one(LawOf<double>{}), ...);
        return law;
    }
};

const std::map<std::string, InflowShape> inflow_shapes = {
    {"uniform", InflowShape::uniform}, {"pitt-peters", InflowShape::pitt_peters}, {"coleman", InflowShape::coleman},
    {"pitt-peters-gradient", InflowShape::pitt_peters_gradient}, {"white-blake", InflowShape::white_blake},
    {"drees", InflowShape::drees}};

// C_L and C_D (2, N) of a section, at angles of attack from the chord line [rad] and Reynolds numbers.
Numbers section_coefficients(const nb::dict& of, Vector alpha, Vector reynolds) {
    double* found;
    const std::size_t n = alpha.size();
    expect("reynolds", reynolds.size(), n);
    auto array = make_array({2, n}, found);
    std::visit([&](const auto& law) {
        for (std::size_t k = 0; k < n; k += width) {
            const auto at = [&](const Vector& v) {
                return each_lane([&](int j) { return v.data()[std::min(k + j, n - 1)]; });
            };
            const Lanes re = at(reynolds), from = at(alpha);
            const auto turn = [&](Lanes angle) {
                return angle_from(each_lane([&](int j) { return std::remainder((from - angle)[j], 2.0 * pi); }));
            };
            const SectionFlow flow{turn(law.zero_lift_angle_at(re) + Lanes{}), turn(law.least_drag_angle_at(re) + Lanes{}),
                                   Lanes{}, re, 1.0 / square_root(re),
                                   law.lift_growth_at(re) + Lanes{}, law.drag_growth_at(re) + Lanes{}};
            const auto c = law.coefficients(flow);
            for (int j = 0; j < width && k + j < n; ++j) found[k + j] = c.lift[j], found[n + k + j] = c.drag[j];
        }
    }, Variants<Laws>::read({of}));
    return array;
}

// Solver for the loads of one rotor, with its model, at any operating point.
class CoreRotor {
  public:
    CoreRotor(const nb::dict& blade, const nb::dict& law, const nb::dict& air, const nb::dict& corrections, bool fine)
        : blade_(std::make_unique<BladeShape>(shape(blade))), solver_(make({law}, {air}, {corrections}, fine)) {}

    // Loads and the other numbers that `keep` writes, (11, N), and derivatives (6, P, N) of loads with respect to `names`.
    nb::tuple loads(const Points& points, const std::vector<std::string>& names, int threads) const {
        const std::size_t n = points.shape(1);
        double *found, *slopes;
        auto found_array = make_array({kept, n}, found), slope_array = make_array({Loads<double>::count, names.size(), n}, slopes);
        std::vector<std::size_t> which;
        for (const auto known = names.empty() ? names : names_of(solver_); const auto& name : names) {
            which.push_back(std::find(known.begin(), known.end(), name) - known.begin());
            if (which.back() == known.size()) throw nb::key_error(name.c_str());
        }
        std::visit([&](const auto& solver) {
            for_each_point(n, threads, [&](std::size_t k) {
                thread_local Solution s, at_rest;
                solver.solve(point(points, k), s);
                keep(s, solver.rotor(), found, k, n);
                if (which.empty()) return;
                if (s.flow.v_axial < 0.0) solver.solve({s.flow.omega, 0.0, 0.0}, at_rest);
                write_slopes(solver_, s, at_rest, which, slopes + k, n);
            });
        }, solver_);
        return nb::make_tuple(found_array, slope_array);
    }

    int inflow_size() const {  // number of values in a state of the dynamic inflow; 0 if the inflow has no dynamics
        return std::visit([&](const auto& solver) {
            return solver.rotor().inflow_shape > InflowShape::pitt_peters ? 0 : dynamic(solver).size();
        }, solver_);
    }

    // Return states (..., size) after steps of `time` (...) [s]; rates of `state` if `time` is `...`; static states if
    // `state` is `...`.  Also return rows (..., 17) before the step: force and moment on the vehicle in the rotor frame,
    // and the numbers that `keep` writes.  `spin` (...) is 1 for counter-clockwise.
    nb::tuple inflow_motion(nb::handle x, nb::handle dt, nb::handle w, nb::handle v, nb::handle turning, int threads) const {
        const std::size_t size = inflow_size(), row = 6 + kept;
        expect("state", size, harmonics_first, true);
        const Argument state("state", x, size), time("dt", dt, 0, false), omega("omega", w, 0, false);
        const Argument velocity("velocity", v, 3), spin("spin", turning);
        const Shape shape = Argument::shape_of({&omega, &velocity, &state, &time, &spin});
        double *moved, *rows;
        auto moved_array = make_array(shape, moved, size), row_array = make_array(shape, rows, row);
        std::visit([&](const auto& solver) {
            for_each_point(row_array.size() / row, threads, [&, &inflow = dynamic(solver)](std::size_t k) {
                HubFlow hub = hub_flow(up, vector(velocity.at(k, shape)));
                if (hub.inplane == 0.0) hub.ahead = {1.0, 0.0, 0.0};
                const Flow<double> flow{*omega.at(k, shape), hub.axial, hub.inplane};
                const Heading heading{hub.ahead[0], hub.ahead[1], *spin.at(k, shape)};
                double *to = moved + size * k, *into = rows + row * k;
                if (!state.given()) inflow.steady(flow, heading, to);
                const Solution& s = inflow.move(flow, heading, state.given() ? state.at(k, shape) : to, *time.at(k, shape),
                                                state.given() && !time.given() ? to : nullptr, time.given() ? to : nullptr);
                const Wrench on = hub_wrench(up, heading.spin, hub.ahead, s.result.loads);
                keep(s, solver.rotor(), ::keep(on.moment, ::keep(on.force, into)), 0, 1);
            });
        }, solver_);
        return nb::make_tuple(moved_array, row_array);
    }

    // Fields over the disk at one operating point, for S radii, at most `most_nodes`: arrays (S, 4) and (S, P, 6).
    nb::tuple disk_field(const Points& points, const std::vector<double>& radii, const std::vector<double>& psi) const {
        expect("points", points.shape(1), 1), expect("radii", std::min(radii.size(), std::size_t(most_nodes)), radii.size());
        double *mean, *local;
        auto means = make_array({radii.size(), 4}, mean), locals = make_array({radii.size(), psi.size(), 6}, local);
        std::visit([&](const auto& solver) {
            Solution s;
            solver.solve(point(points, 0), s);
            if (!radii.empty()) propmap::disk_field(solver, s, radii, psi, mean, local);
        }, solver_);
        return nb::make_tuple(means, locals);
    }

    // Thrust [N] of fully attached blades: a fast first estimate.
    Numbers attached_thrust(const Points& points) const {
        double* found;
        auto array = make_array({points.shape(1)}, found);
        for (std::size_t k = 0; k < points.shape(1); ++k) found[k] = attached(point(points, k));
        return array;
    }
    double attached(const Flow<double>& flow) const {
        return std::visit([&](const auto& solver) { return propmap::attached_thrust(solver.rotor(), flow); }, solver_);
    }

    // The solution at one operating point: radius, inflow and residual of the nodes, and the edges of the panels.
    nb::dict solution(const Points& points) const {
        expect("points", points.shape(1), 1);
        return std::visit([&](const auto& solver) {
            Solution s;
            solver.solve(point(points, 0), s);
            const auto of = solver.annuli(s);
            nb::dict result;
            result["nodes"] = columns(s.disk.nodes, [&](std::size_t k) {
                const auto& at = s.disk.at[k / width];
                const Lanes inflow = s.disk.inflow[k / width], residual = solver.rotor().density * of.residual(at, inflow).v;
                return std::array{at.radius[k % width], inflow[k % width], residual[k % width]};
            });
            result["edges"] = columns(s.disk.panels + 1, [&](std::size_t k) { return std::array{s.disk.edge[k].radius}; });
            nb::list folds;
            const char* kinds[] = {"", "fold", "shoulder", "angle"};
            for (int k = 0; k <= s.disk.panels; ++k) folds.append(kinds[int(s.disk.edge[k].kind)]);
            result["folds"] = folds, result["azimuths"] = 2 * s.psi.count, result["windmill"] = s.windmill;
            return result;
        }, solver_);
    }

    // Compute the loads and return the status.  The inflow is that in `state`, or static if `state` is null.  If
    // `at_rest`, the static state is first written to `state`.  `later` receives the state after a step of `time` [s].
    Status loads_in(const Flow<double>& flow, const Heading& heading, bool at_rest, double time, double* state, double* later,
                    Loads<double>& into) const {
        thread_local Solution still;
        return std::visit([&](const auto& solver) {
            if (!state) solver.solve(flow, still);
            else if (at_rest) dynamic(solver).steady(flow, heading, state);
            const Solution& s = state ? dynamic(solver).move(flow, heading, state, time, nullptr, later) : still;
            into = s.result.loads;
            return s.result.status;
        }, solver_);
    }

  private:
    template <template <class> class LawOf> const DynamicInflow<LawOf>& dynamic(const RotorSolver<LawOf>& solver) const {
        std::call_once(motion_made_, [&] { motion_ = DynamicInflow<LawOf>(solver); });
        return std::get<DynamicInflow<LawOf>>(motion_);
    }

    static BladeShape shape(const nb::dict& blade) {
        BladeShape shape{{}, nb::cast<double>(blade["root"]), nb::cast<double>(blade["tip"]), nb::cast<int>(blade["blades"])};
        const auto rows = nb::cast<Intervals>(blade["intervals"]);
        expect("intervals", rows.shape(0), 1, true);
        shape.intervals.resize(rows.shape(0));
        std::memcpy(shape.intervals.data(), rows.data(), rows.nbytes());
        return shape;
    }

    // Write loads, status, number of roots, weight of the vortex ring, mean inflow and reverse-flow share of point k of n.
    static constexpr std::size_t kept = Loads<double>::count + 5;
    template <class R> static void keep(const Solution& s, const R& rotor, double* into, std::size_t k, std::size_t n) {
        const double known[] = {double(s.result.status), double(s.result.roots), s.result.ring, s.result.mean_inflow,
                                reverse_flow_share(s.flow, rotor.root(), rotor.tip())};
        for (int j = 0; j < Loads<double>::count; ++j, into += n) into[k] = s.result.loads.begin()[j];
        for (double value : known) into[k] = value, into += n;
    }

    // The rotor from dictionaries of numbers.  It precedes `make`: clang 19 omits a member template that follows its use.
    template <template <class> class LawOf>
    Rotor<double, LawOf> rotor(const LawOf<double>& law, const Source& air, const Source& with) {
        Rotor<double, LawOf> r;
        r.blade = blade_.get();
        static_cast<LawOf<double>&>(r.law) = law;
        r.density = air.number("density"), r.viscosity = air.number("viscosity");
        r.change.untwist = with.number("blade-untwist", 0.0);
        r.tip_loss = with.has("tip-loss"), r.hub_radius = with.number("hub-loss", 0.0);
        if (with.has("inflow")) r.inflow_shape = inflow_shapes.at(nb::cast<std::string>(with.from["inflow"]));
        r.installed = with.has("installed");
        r.drag_factor = with.number("installed", 1.0), r.mount_area = with.number("mount-area", 0.0);
        r.mount_wake = with.number("mount-wake", 1.0);
        r.law.stall_delay = with.number("stall-delay", 0.0), r.law.speed_of_sound = with.number("prandtl-glauert", 0.0);
        r.radial_friction = with.has("radial-friction");
        return r;
    }

    AnySolver make(const Source& law, const Source& air, const Source& corrections, bool fine) {
        const Accuracy& accuracy = fine ? fine_accuracy : standard_accuracy;
        return std::visit([&](const auto& found) -> AnySolver { return RotorSolver(rotor(found, air, corrections), accuracy); },
                          Variants<Laws>::read(law));
    }

    std::unique_ptr<BladeShape> blade_;
    AnySolver solver_;
    mutable std::once_flag motion_made_;
    mutable Variants<Laws>::Motion motion_;  // made on first use
};

TableAxis axis_of(const nb::tuple& from, std::size_t values) {  // the axis from knots and polynomials, for as many values
    TableAxis axis{array_of(from[0]), array_of(from[1])};
    const std::size_t n = axis.knots.size();
    expect("knots", n, 2, true), expect("polynomials", axis.polynomials.size(), 16 * (n - 1)), expect("values", values, n + 2);
    return axis;
}

// A load table: knots and polynomials of both axes, values (n + 2, m + 2, 2 L), cells (n - 1, m - 1), limits (3, 2).
class CoreTable : public LoadTable {
  public:
    using Values = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
    using Cells = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

    CoreTable(const nb::tuple& of_advance, const nb::tuple& of_beta, Values given, Cells codes, const nb::tuple& box, double tip) {
        constexpr std::size_t each = std::tuple_size_v<LoadTable::Row>;
        advance = axis_of(of_advance, given.shape(0)), beta = axis_of(of_beta, given.shape(1));
        expect("values", given.shape(2), each);
        expect("cells", codes.shape(0), given.shape(0) - 3), expect("cells", codes.shape(1), given.shape(1) - 3);
        values.resize(given.size() / each);
        std::copy_n(given.data(), given.size(), values.front().data());
        for (std::size_t k = 0; k < codes.size(); ++k) cells.push_back(TableStatus(codes.data()[k]));
        for (int k = 0; k < 3; ++k) low[k] = nb::cast<double>(box[k][0]), high[k] = nb::cast<double>(box[k][1]);
        radius = tip;
    }

    // Loads, power and the code of the status at one point.
    std::array<double, count + 2> point(double omega, double speed, double angle, bool clamp) const {
        const auto f = LoadTable::loads(omega, speed, angle, clamp);
        std::array<double, count + 2> found;
        auto* rest = std::copy_n(f.loads.begin(), count, found.data());
        rest[0] = f.loads.torque * f.omega, rest[1] = double(f.status);
        return found;
    }

    // Omega, speed and beta of N points.
    using Points = nb::ndarray<const double, nb::shape<3, -1>, nb::c_contig, nb::device::cpu>;

    Numbers loads(Points at, bool clamp) const {  // the numbers of `point`, (L + 2, N)
        return columns(at.shape(1), [&](std::size_t k) { return point(at(0, k), at(1, k), at(2, k), clamp); });
    }

    Numbers bounded(Points given) const {  // points brought into the envelope (3, N); omega is NaN for points outside
        return columns(given.shape(1), [&](std::size_t k) {
            const auto at = LoadTable::bounded(given(0, k), given(1, k), given(2, k), false);
            return std::array{at.omega, at.speed, at.beta};
        });
    }

    // Values at J and beta with their derivatives (N, 2, 2, 2 L).
    Numbers slopes(Vector at_advance, Vector angle) const {
        expect("beta", angle.size(), at_advance.size());
        double* to;
        auto array = make_array({angle.size(), 2, 2, std::tuple_size_v<LoadTable::Row>}, to);
        for (std::size_t k = 0; k < angle.size(); ++k)
            for (const auto& row : LoadTable::slopes(at_advance(k), angle(k))) to = std::copy(row.begin(), row.end(), to);
        return array;
    }
};

// Rows (5, N): axial speed, in-plane speed, and the unit vector against the in-plane velocity (downstream); from the
// velocities of N hubs (N, 3) and the thrust axes of m rotors (m, 3).  Hub k belongs to rotor k % m.
Numbers hub_flows(Vectors axes, Vectors hubs) {
    const std::size_t m = axes.shape(0);
    expect("axes", m, 1, true);
    return columns(hubs.shape(0), [&](std::size_t k) {
        const HubFlow flow = hub_flow(vector(axes.data() + 3 * (k % m)), vector(hubs.data() + 3 * k));
        return std::array{flow.axial, flow.inplane, -flow.ahead[0], -flow.ahead[1], -flow.ahead[2]};
    });
}

// Forces, and moments about the hubs, (P, N, 3) each, from loads (L, P, N); arguments as in `hub_flows`.
nb::tuple hub_wrenches(Vectors axes, Vector spins, Vectors downstream,
                       nb::ndarray<const double, nb::shape<Loads<double>::count, -1, -1>, nb::c_contig, nb::device::cpu> loads) {
    const std::size_t p = loads.shape(1), n = loads.shape(2), m = axes.shape(0);
    expect("axes", m, 1, true), expect("spins", spins.size(), m), expect("downstream", downstream.shape(0), n);
    return vector_pairs({p, n}, [&](std::size_t k) {
        Loads<double> one;
        for (int j = 0; j < Loads<double>::count; ++j) one.begin()[j] = loads(j, k / n, k % n);
        const Vector3 ahead = add({}, -1.0, vector(&downstream(k % n, 0)));
        return hub_wrench(vector(&axes(k % n % m, 0)), spins(k % n % m), ahead, one);
    });
}

Airframe airframe(const Source& from) {
    Airframe of{from.number("density")};
    const auto drag = from.numbers("drag_area", 3), download = from.numbers("download_area", 2);
    std::copy_n(drag.begin(), 3, of.drag_area.begin()), std::copy_n(download.begin(), 2, of.download_area);
    of.lift_area = from.number("lift_area"), of.plate_area = from.number("plate_area");
    if (!from.has("wing")) return of;
    of.wing_area = from.number("wing_area"), of.incidence = from.number("incidence"), of.span = from.number("span");
    of.wing = std::get<BlendedLaw<double>>(Variants<Laws>::read({nb::cast<nb::dict>(from.from["wing"])}));
    return of;
}

// Forces of body and wing, (N, 3) each.
nb::tuple free_stream_forces(const nb::dict& of, Vectors velocity) {
    const Airframe frame = airframe({of});
    return vector_pairs({velocity.shape(0)}, [&](std::size_t k) {
        const Vector3 v = vector(&velocity(k, 0));
        return std::pair{frame.body_force(v), frame.wing_force(v)};
    });
}

// The wakes of the m rotors of a vehicle on each other.
class CoreWakes : public Interaction {
  public:
    using Splines = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

    // Rows of `frames`: two directions in the disk of each rotor, and its axis.  Rows of `pairs` (target, source): index of
    // the spline, bearing, and whether gains do not apply.  `values`: coefficients (spline, skew, bearing).
    CoreWakes(Vectors axes, Vectors rows, const nb::tuple& skew, const nb::tuple& bearing, Splines values) {
        const std::size_t m = axes.shape(0) / 3;
        expect("frames", axes.shape(0), 3 * m), expect("pairs", rows.shape(0), m * m);
        skews = axis_of(skew, values.shape(1)), bearings = axis_of(bearing, values.shape(2));
        coefficients.assign(values.data(), values.data() + values.size());
        for (const double* row = axes.data(); frames.size() < m; row += 9)
            frames.push_back({vector(row), vector(row + 3), vector(row + 6)});
        for (const double* row = rows.data(); pairs.size() < m * m; row += 3) {
            const bool itself = pairs.size() % (m + 1) == 0;
            if (!itself && !(row[0] >= 0.0 && row[0] < double(values.shape(0)))) refuse("a pair of rotors has no spline of its wake");
            pairs.push_back({itself ? 0 : std::size_t(row[0]), row[1], row[2] != 0.0});
        }
    }

    static WakeGains gains(Vector from) {
        expect("gains", from.size(), 5);
        const double* g = from.data();
        return {g[0], g[1], g[2], g[3], g[4]};
    }

    // Inflow (n, m), velocity added at each rotor (n, m), and its derivatives by the gains (4, n, m) and by each thrust
    // (n, m, m).
    nb::tuple flow(Vector gains, Vector axial, Vector inplane, Vectors downstream, Vector thrust) const {
        const std::size_t m = frames.size(), size = axial.size(), n = size / std::max<std::size_t>(m, 1);
        const WakeGains with = CoreWakes::gains(gains);
        expect("axial", size, n * m), expect("inplane", inplane.size(), size), expect("thrust", thrust.size(), size);
        expect("downstream", downstream.shape(0), size);
        double *inflow, *added, *by_gain, *by_thrust;
        auto all = nb::make_tuple(make_array({n, m}, inflow), make_array({n, m}, added), make_array({4, n, m}, by_gain),
                                  make_array({n, m, m}, by_thrust));
        std::vector<HubFlow> at(m);
        for (std::size_t first = 0; first < size; first += m) {
            for (std::size_t k = 0, j = first; k < m; ++k, ++j) {
                at[k] = {axial.data()[j], inplane.data()[j], add({}, -1.0, vector(downstream.data() + 3 * j))};
                inflow[j] = glauert_inflow(thrust.data()[j], at[k].axial, at[k].inplane, with.disk)[0];
            }
            effects(with, at.data(), thrust.data() + first, [&](std::size_t target, std::size_t source, const WakeEffect& e) {
                added[first + target] += e.added, by_thrust[(first + target) * m + source] = e.by_thrust;
                for (std::size_t j = 0; j < 4; ++j) by_gain[j * size + first + target] += e.by_gain[j];
            });
        }
        return all;
    }
};

// A vehicle as a free body in a simulator: forces of the air and of the spinning rotors, for one state at a time.
class FreeBody {
  public:
    using Forces = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
    using Codes = nb::ndarray<std::uint8_t, nb::shape<2, -1>, nb::c_contig, nb::device::cpu>;
    using Mounts = nb::ndarray<const double, nb::shape<-1, 7>, nb::c_contig, nb::device::cpu>;

    // Rows of `mounts` (k, 7): position, axis, spin.  `sources` has a rotor or a table for each.  `wakes` may be null.
    FreeBody(Mounts mounts, const nb::dict& frame, const nb::list& sources, double heavy, Vector center, bool clamp,
             const CoreWakes* wakes, Vector gains)
        : frame_(airframe({frame})), sources_(sources), heavy_(heavy), clamp_(clamp), wakes_(wakes) {
        if (wakes) gains_ = CoreWakes::gains(gains), expect("mounts", mounts.shape(0), wakes->frames.size());
        expect("sources", sources.size(), mounts.shape(0)), expect("center", center.size(), 3);
        center_ = vector(center.data());
        for (std::size_t k = 0; k < mounts.shape(0); ++k) {
            const double* row = mounts.data() + 7 * k;
            mounts_.push_back({vector(row), vector(row + 3), row[6]});
            const CoreRotor* rotor = nullptr;
            const CoreTable* table = nullptr;
            if (!nb::try_cast(sources[k], rotor) || !rotor) table = nb::cast<const CoreTable*>(sources[k]);
            if (!rotor && !table) refuse("a source of loads is None", "give a Rotor or a Table");
            const Vector3 x = hub_flow(mounts_[k].axis, {1.0, 0.0, 0.0}).ahead, z = {0.0, 0.0, 1.0};
            const bool forward = std::fabs(mounts_[k].axis[0]) > 0.9;  // then x and the axis are nearly parallel
            of_.push_back({rotor, table, forward ? hub_flow(mounts_[k].axis, z).ahead : x});
            inflow_size_ += rotor ? rotor->inflow_size() : 0;
        }
    }

    std::size_t inflow_size() const { return inflow_size_; }  // number of values in the inflow states of all rotors

    // Add force (world frame) and moment about the body's origin (body frame) to `forces`.  If a rotor has no finite loads
    // or speed, or turns backward, add nothing and return the first such rotor.  `pose`: position and quaternion.  `motion`: velocity of the
    // origin (world frame) and angular velocity (body frame).  `omega` and `change` have one number per rotor.  `codes`
    // receives the status of each rotor, and its worst status so far.  `inflow` contains the inflow states of the rotors;
    // `later` receives the states after a step of `time` [s].  If `at_rest`, the states are first set to steady solutions.
    std::optional<std::size_t> push(Vector pose, Vector motion, Vector wind, Vector omega, Vector change, Forces forces, Codes codes,
                                    Forces inflow, Forces later, double time, bool at_rest) const {
        const std::size_t k_all = mounts_.size();
        expect("pose", pose.size(), 7), expect("motion", motion.size(), 6), expect("wind", wind.size(), 3);
        expect("omega", omega.size(), k_all), expect("change", change.size(), k_all);
        expect("forces", forces.size(), 6), expect("codes", codes.shape(1), k_all);
        expect("inflow", inflow.size(), inflow_size_), expect("later", later.size(), inflow_size_);
        const double* q = pose.data() + 3;
        const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        const Attitude attitude{q[0] / size, {q[1] / size, q[2] / size, q[3] / size}};
        const Vector3 rates = vector(motion.data() + 3);
        const Vector3 through = attitude.turned(add(vector(motion.data()), -1.0, vector(wind.data())), -1.0);
        const Vector3 velocity = add(through, 1.0, cross(rates, center_));
        std::uint8_t *now = codes.data(), *worst = now + k_all;
        double *state = inflow.data(), *next = later.data();
        std::optional<std::size_t> lost;
        thread_local std::vector<double> added, thrust;
        thread_local std::vector<HubFlow> flows;
        added.assign(k_all, 0.0), thrust.clear(), flows.clear();
        for (const Mount& m : mounts_) flows.push_back(hub_flow(m.axis, add(velocity, 1.0, cross(rates, m.position))));
        const auto flow_at = [&](std::size_t k) {
            return Flow<double>{std::max(omega.data()[k], 0.0), flows[k].axial + added[k], flows[k].inplane};
        };
        if (wakes_) {
            for (std::size_t k = 0; k < k_all; ++k) {
                const auto& [rotor, table, x] = of_[k];
                thrust.push_back(rotor ? rotor->attached(flow_at(k)) : from_table(*table, flow_at(k)).loads.thrust);
                if (!lost && !std::isfinite(thrust[k])) lost = k;
            }
            wakes_->effects(gains_, flows.data(), thrust.data(),
                            [&](std::size_t target, std::size_t, const WakeEffect& e) { added[target] += e.added; });
        }
        Wrench all{add(frame_.body_force(velocity), 1.0, frame_.wing_force(velocity)), {}};
        for (std::size_t k = 0; k < k_all; ++k) {
            const auto& [rotor, table, x] = of_[k];
            Vector3& ahead = flows[k].ahead;
            Loads<double> loads;
            if (table != nullptr) {
                const auto found = from_table(*table, flow_at(k));
                loads = found.loads, now[k] = std::uint8_t(found.status);
            } else {
                if (flows[k].inplane == 0.0) ahead = x;  // without in-plane flow, the rotor frame defines the directions
                const Heading heading{dot(ahead, x), dot(ahead, cross(mounts_[k].axis, x)), mounts_[k].spin};
                const int values = rotor->inflow_size();
                now[k] = std::uint8_t(rotor->loads_in(flow_at(k), heading, at_rest, time, values ? state : nullptr, next, loads));
                state += values, next += values;
            }
            worst[k] = std::max(worst[k], now[k]);
            const bool backward = omega.data()[k] < -1e-9;  // rounding of a stopped rotor is accepted
            if (!lost && (backward || !std::isfinite(loads.thrust) || !std::isfinite(omega.data()[k] + change.data()[k]))) lost = k;
            add_rotor(all, mounts_[k], ahead, loads);
        }
        if (lost) return lost;
        all.moment = add(all.moment, 1.0, spin_moment(mounts_, heavy_, omega.data(), change.data(), rates));
        const Vector3 force = attitude.turned(all.force, 1.0), moment = add(all.moment, 1.0, cross(center_, all.force));
        for (int j = 0; j < 3; ++j) forces.data()[j] += force[j], forces.data()[3 + j] += moment[j];
        return {};
    }

  private:
    struct Source {
        const CoreRotor* rotor;
        const CoreTable* table;
        Vector3 x;        // of the rotor frame
    };
    LoadTable::Found from_table(const CoreTable& of, const Flow<double>& flow) const {
        const double speed = std::hypot(flow.v_axial, flow.v_inplane), beta = std::atan2(flow.v_inplane, flow.v_axial);
        return of.LoadTable::loads(flow.omega, speed, beta, clamp_);
    }

    std::vector<Mount> mounts_;
    Airframe frame_;
    nb::list sources_;  // keeps the objects in `of_` alive
    double heavy_;
    Vector3 center_;
    bool clamp_;
    const CoreWakes* wakes_;
    WakeGains gains_{};
    std::size_t inflow_size_ = 0;
    std::vector<Source> of_;
};

// Choice of the build for this processor, from its instruction sets and the registers that the operating system saves.
// (__builtin_cpu_supports finds nothing in code that Zig has compiled.)
const char* best_instructions() {
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

}  // namespace

NB_MODULE(PROPMAP_MODULE, m) {
    nb::set_leak_warnings(false);  // MuJoCo keeps its callbacks until Python ends
    m.def("instructions", [] { return PROPMAP_INSTRUCTIONS; });
    m.def("best_instructions", &best_instructions);
    m.def("section_coefficients", &section_coefficients);
    nb::class_<CoreRotor>(m, "Rotor")
        .def(nb::init<const nb::dict&, const nb::dict&, const nb::dict&, const nb::dict&, bool>())
        .def("loads", &CoreRotor::loads)
        .def("solution", &CoreRotor::solution)
        .def_prop_ro("inflow_size", &CoreRotor::inflow_size)
        .def("inflow_motion", &CoreRotor::inflow_motion, nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg(), nb::arg())
        .def("disk_field", &CoreRotor::disk_field)
        .def("attached_thrust", &CoreRotor::attached_thrust);
    nb::class_<CoreTable>(m, "Table")
        .def(nb::init<const nb::tuple&, const nb::tuple&, CoreTable::Values, CoreTable::Cells, const nb::tuple&, double>())
        .def("point", &CoreTable::point)
        .def("loads", &CoreTable::loads)
        .def("bounded", &CoreTable::bounded)
        .def("slopes", &CoreTable::slopes);
    m.def("hub_flows", &hub_flows);
    m.def("hub_wrenches", &hub_wrenches);
    m.def("free_stream_forces", &free_stream_forces);
    nb::dict limits;
    limits["largest_inflow"] = largest_inflow, limits["full_upwash"] = full_upwash, limits["largest_upwash"] = largest_upwash;
    limits["slow_flow"] = slow_flow, limits["inflow_steps"] = inflow_steps;
    m.attr("wake_limits") = limits;
    nb::class_<CoreWakes>(m, "Wakes")
        .def(nb::init<Vectors, Vectors, const nb::tuple&, const nb::tuple&, CoreWakes::Splines>())
        .def("flow", &CoreWakes::flow);
    nb::class_<FreeBody>(m, "FreeBody")
        .def(nb::init<FreeBody::Mounts, const nb::dict&, const nb::list&, double, Vector, bool, const CoreWakes*, Vector>(),
             nb::keep_alive<1, 8>(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg().none(), nb::arg())
        .def_prop_ro("inflow_size", &FreeBody::inflow_size)
        .def("push", &FreeBody::push);
}
