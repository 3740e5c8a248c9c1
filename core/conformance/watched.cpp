#include "core/conformance/watched.hpp"

#include <chrono>
#include <new>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include "core/conformance/report.hpp"

namespace somas::conformance {
namespace {

using Clock = std::chrono::steady_clock;
using model::CallSite;

std::atomic<CallSite*> all_calls = nullptr;
std::atomic<std::int64_t> nanoseconds_in_steps = 0;

void count_call() {
  if (CallSite* site = all_calls) site->progress.fetch_add(1, std::memory_order_relaxed);
}

/// Adds the time that it lives.
class Stopwatch {
 public:
  Stopwatch() = default;
  ~Stopwatch() {
    nanoseconds_in_steps +=
        std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - begun_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  Clock::time_point begun_ = Clock::now();
};

/// The calls of one instance.
class Calls {
 public:
  Calls(std::string id, bool names_calls) : id_(std::move(id)), names_calls_(names_calls) {}

  template <class Body>
  auto operator()(const char* call, Body&& body, std::uint64_t step = CallSite::no_step) const {
    return guarded(call, std::forward<Body>(body), step, names_calls_);
  }
  /// The same, but what is thrown passes as it is: it is an answer.
  template <class Body>
  auto answered(const char* call, Body&& body) const {
    return guarded(call, std::forward<Body>(body), CallSite::no_step, false);
  }

 private:
  template <class Body>
  auto guarded(const char* call, Body&& body, std::uint64_t step, bool names_calls) const {
    const model::PluginCall here(id_, call, step);
    count_call();
    try {
      return body();
    } catch (const std::bad_alloc&) {
      // Nobody knows what is left of the process.
      ::_exit(examiner_no_memory);
    } catch (const ParameterError& error) {
      if (!names_calls) throw;
      throw std::runtime_error(std::string(call) + ": the parameter '" + error.path() +
                               "': " + error.what());
    } catch (const std::exception& error) {
      if (!names_calls) throw;
      throw std::runtime_error(std::string(call) + ": " + error.what());
    } catch (...) {
      if (!names_calls) throw;
      throw std::runtime_error(std::string(call) + ": an exception that is no std::exception");
    }
  }

  std::string id_;
  bool names_calls_;
};

class WatchedHeritable final : public Heritable {
 public:
  WatchedHeritable(const Heritable& inner, Calls calls) : inner_(inner), calls_(std::move(calls)) {}
  [[nodiscard]] void* extension(std::string_view id) const override { return inner_.extension(id); }

  void random(const Layout& layout, Rng& rng, Genes& genes) const override {
    calls_("random", [&] { inner_.random(layout, rng, genes); });
  }
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override {
    calls_("conform", [&] { inner_.conform(layout, rng, genes); });
  }
  void mutate(const Layout& layout, Rng& rng, Genes& genes) const override {
    calls_("mutate", [&] { inner_.mutate(layout, rng, genes); });
  }
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override {
    calls_("cross", [&] { inner_.cross(layout, first, second, rng, child); });
  }
  [[nodiscard]] double distance(GenesView first, GenesView second) const override {
    return calls_("distance", [&] { return inner_.distance(first, second); });
  }
  void to_json(GenesView genes, JsonWriter& out) const override {
    calls_("to_json", [&] { inner_.to_json(genes, out); });
  }
  void from_json(const JsonReader& in, Genes& genes) const override {
    calls_("from_json", [&] { inner_.from_json(in, genes); });
  }
  void check(const Layout& layout, GenesView genes) const override {
    calls_.answered("check", [&] { inner_.check(layout, genes); });
  }

 private:
  const Heritable& inner_;
  Calls calls_;
};

const char* call_of(Phase phase) {
  switch (phase) {
    case Phase::fields:
      return "act(fields)";
    case Phase::sense:
      return "act(sense)";
    case Phase::forces:
      return "act(forces)";
    case Phase::stress:
      return "act(stress)";
    case Phase::parameters:
      return "act(parameters)";
  }
  return "act";
}

/// What instances of all kinds share: the instance itself, and its construction.
template <class Interface>
class Watched : public Interface {
 public:
  explicit Watched(const Making& making)
      : calls_(making.plugin.id(), making.names_calls), inner_(calls_("constructor", [&] {
          return making.plugin.create<Interface>(making.parameters);
        })) {}
  [[nodiscard]] void* extension(std::string_view id) const override {
    return inner_->extension(id);
  }

 protected:
  Calls calls_;
  std::shared_ptr<Interface> inner_;
};

class WatchedEnvironment final : public Watched<Environment> {
 public:
  using Watched::Watched;
  void declare(Declare& declare) override {
    calls_("declare", [&] { inner_->declare(declare); });
  }
  void connect(Connections& connections) override {
    calls_("connect", [&] { inner_->connect(connections); });
  }
  void begin(World& world) const override {
    calls_(
        "begin", [&] { inner_->begin(world); }, world.step());
  }
  void act(Phase phase, World& world) const override {
    const Stopwatch here;
    calls_(
        call_of(phase), [&] { inner_->act(phase, world); }, world.step());
  }
};

class WatchedSpecialization final : public Watched<Specialization> {
 public:
  using Watched::Watched;
  void declare(std::span<const SkillInfo> skills) override {
    calls_("declare", [&] { inner_->declare(skills); });
    // Not before: an instance may have to know the skills first.
    const Heritable* genes = calls_("heritable", [&] { return inner_->heritable(); });
    if (genes != nullptr) genes_ = std::make_unique<WatchedHeritable>(*genes, calls_);
  }
  [[nodiscard]] const Heritable* heritable() const override { return genes_.get(); }
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override {
    const Stopwatch here;
    calls_("grow", [&] { inner_->grow(genes, skills, tree); });
  }

 private:
  std::unique_ptr<WatchedHeritable> genes_;
};

class WatchedProgram final : public Program {
 public:
  WatchedProgram(std::unique_ptr<Program> inner, Calls calls)
      : inner_(std::move(inner)), calls_(std::move(calls)) {}
  [[nodiscard]] void* extension(std::string_view id) const override {
    return inner_->extension(id);
  }
  [[nodiscard]] std::uint32_t memory_per_cell() const override {
    return calls_("memory_per_cell", [&] { return inner_->memory_per_cell(); });
  }
  void start(const Batch& batch) const override {
    calls_("start", [&] { inner_->start(batch); });
  }
  void step(const Batch& batch) const override {
    const Stopwatch here;
    calls_("step", [&] { inner_->step(batch); });
  }

 private:
  std::unique_ptr<Program> inner_;
  Calls calls_;
};

class WatchedController final : public Watched<Controller> {
 public:
  explicit WatchedController(const Making& making)
      : Watched(making),
        genes_(*calls_("heritable", [&] { return &inner_->heritable(); }), calls_) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes,
                                                 const Layout& layout) const override {
    std::unique_ptr<Program> program =
        calls_("express", [&] { return inner_->express(genes, layout); });
    if (!program) return nullptr;
    return std::make_unique<WatchedProgram>(std::move(program), calls_);
  }

 private:
  WatchedHeritable genes_;
};

class WatchedFitness final : public Watched<Fitness> {
 public:
  using Watched::Watched;
  void declare(Declare& declare) override {
    calls_("declare", [&] { inner_->declare(declare); });
  }
  [[nodiscard]] std::string_view objective() const override {
    return calls_("objective", [&] { return inner_->objective(); });
  }
  [[nodiscard]] bool observe(World& world) const override {
    const Stopwatch here;
    return calls_(
        "observe", [&] { return inner_->observe(world); }, world.step());
  }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    return calls_("score", [&] { return inner_->score(outcome); });
  }
};

}  // namespace

void watch_calls(CallSite* site) {
  all_calls = site;
  model::watched_site = site;
}

std::unique_ptr<Environment> make_environment(const Making& making) {
  return std::make_unique<WatchedEnvironment>(making);
}
std::unique_ptr<Specialization> make_specialization(const Making& making) {
  return std::make_unique<WatchedSpecialization>(making);
}
std::unique_ptr<Controller> make_controller(const Making& making) {
  return std::make_unique<WatchedController>(making);
}
std::unique_ptr<Fitness> make_fitness(const Making& making) {
  return std::make_unique<WatchedFitness>(making);
}

double seconds_in_steps() { return 1e-9 * static_cast<double>(nanoseconds_in_steps); }

}  // namespace somas::conformance
