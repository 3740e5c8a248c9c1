#include "core/conformance/examiner.hpp"

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <exception>
#include <fstream>
#include <functional>
#include <map>
#include <new>
#include <optional>
#include <unistd.h>

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include "somas/sdk/testing.hpp"

#include "core/conformance/companions.hpp"
#include "core/conformance/host_world.hpp"
#include "core/conformance/report.hpp"
#include "core/conformance/timing.hpp"
#include "core/conformance/variants.hpp"
#include "core/experiment/experiment.hpp"
#include "core/plugins/suggest.hpp"

namespace somas::conformance {
namespace {

[[noreturn]] void leave(int code) { ::_exit(code); }

// ---- what libraries are asked for
// ----------------------------------------------------------------

/// Functions of the C library whose results differ from one version or CPU to another; each also
/// with the suffixes f and l.
constexpr std::string_view inexact[] = {
    "acos",   "acosh", "asin", "asinh", "atan",   "atan2", "atanh",  "cbrt",  "cos",
    "cosh",   "erf",   "erfc", "exp",   "exp10",  "exp2",  "expm1",  "hypot", "j0",
    "j1",     "jn",    "log",  "log10", "log1p",  "log2",  "lgamma", "pow",   "sin",
    "sincos", "sinh",  "tan",  "tanh",  "tgamma", "y0",    "y1",     "yn"};

/// What gives something else every time, or on every machine.
constexpr std::string_view capricious[] = {"clock",
                                           "clock_gettime",
                                           "drand48",
                                           "getentropy",
                                           "getenv",
                                           "gethostname",
                                           "getpid",
                                           "getrandom",
                                           "gettimeofday",
                                           "lrand48",
                                           "rand",
                                           "rand_r",
                                           "random",
                                           "secure_getenv",
                                           "time",
                                           "_ZNSt13random_device9_M_getvalEv",
                                           "_ZNSt6chrono3_V212steady_clock3nowEv",
                                           "_ZNSt6chrono3_V212system_clock3nowEv"};

bool is_inexact(std::string_view name) {
  const auto known = [](std::string_view n) {
    return std::find(std::begin(inexact), std::end(inexact), n) != std::end(inexact);
  };
  if (known(name)) return true;
  const bool suffixed = name.ends_with('f') || name.ends_with('l');
  return suffixed && known(name.substr(0, name.size() - 1));
}

/// A function of C++ as its author calls it.
std::string readable(const std::string& name) {
  const std::unique_ptr<char, void (*)(void*)> text(
      abi::__cxa_demangle(name.c_str(), nullptr, nullptr, nullptr), std::free);
  return text ? text.get() : name;
}

bool is_capricious(std::string_view name) {
  return std::find(std::begin(capricious), std::end(capricious), name) != std::end(capricious);
}

// ---- the examination
// -----------------------------------------------------------------------------

/// What looking at a law came to, when nothing was thrown.
struct Told {
  Verdict verdict = Verdict::pass;
  std::string text{};
};

std::string key_of(std::string_view section, std::string_view law) {
  return std::string(section) + "/" + std::string(law);
}

class Examination {
 public:
  Examination(Assignment assignment, Page& page) : assignment_(std::move(assignment)), page_(page) {
    for (const std::string& entry : assignment_.done) {
      const std::size_t colon = entry.find(':');
      done_[entry.substr(colon + 1)] = verdict_named(entry.substr(0, colon));
    }
  }

  void run() {
    if (file_is_sound()) look_at_classes();
    send({.kind = Message::Kind::over});
  }

 private:
  using Body = std::function<Told()>;

  void send(const Message& message) const {
    page_.site.progress.fetch_add(1);
    const std::string line = encode(message);
    for (std::size_t sent = 0; sent < line.size();) {
      const ssize_t count = ::write(examiner_pipe, line.data() + sent, line.size() - sent);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) leave(0);  // nobody listens
      sent += static_cast<std::size_t>(count);
    }
  }

  /// Whether a law is known not to hold, or was skipped for another's sake.
  [[nodiscard]] bool fails(const std::string& law) const {
    const auto entry = done_.find(key_of(section_, law));
    return entry != done_.end() &&
           (entry->second == Verdict::fail || entry->second == Verdict::skip);
  }

  void conclude(Finding finding) {
    finding.section = section_;
    done_[key_of(section_, finding.law)] = finding.verdict;
    send({.kind = Message::Kind::end, .finding = std::move(finding)});
  }

  /// Looks at a law, unless that is done; whether it holds.
  bool look(const std::string& law, const std::string& remedy,
            const std::vector<std::string>& needs, const Body& body) {
    if (done_.contains(key_of(section_, law))) return !fails(law);
    for (const std::string& needed : needs)
      if (fails(needed)) {
        conclude({.law = law, .verdict = Verdict::skip, .text = "needs '" + needed + "'"});
        return false;
      }
    send({.kind = Message::Kind::begin, .finding = {.section = section_, .law = law}});
    Finding finding{.law = law};
    try {
      Told told = body();
      finding.verdict = told.verdict;
      finding.text = std::move(told.text);
    } catch (const std::bad_alloc&) {
      leave(examiner_no_memory);
    } catch (const std::exception& error) {
      finding.verdict = Verdict::fail;
      finding.text = error.what();
    }
    // Calls are often called as the law is.
    if (finding.text.starts_with(law + ": ")) finding.text.erase(0, law.size() + 2);
    if (finding.verdict != Verdict::pass && finding.verdict != Verdict::info)
      finding.remedy = remedy;
    const bool holds = finding.verdict != Verdict::fail;
    conclude(std::move(finding));
    return holds;
  }

  /// All checks, those of one law together.
  void look(const testing::Checks& checks, std::vector<std::string> needs) {
    std::vector<std::string> laws;
    for (const testing::Check& check : checks)
      if (std::find(laws.begin(), laws.end(), check.law) == laws.end()) laws.push_back(check.law);
    for (const std::string& law : laws) {
      std::vector<const testing::Check*> of_law;
      for (const testing::Check& check : checks)
        if (check.law == law) of_law.push_back(&check);
      std::vector<std::string> all_needs = needs;
      all_needs.insert(all_needs.end(), of_law[0]->needs.begin(), of_law[0]->needs.end());
      look(law, of_law[0]->remedy, all_needs, [&] { return together(of_law); });
      if (of_law[0]->first) needs.push_back(law);
    }
  }

  /// What the name of a check says beyond its law: "(layout 1): ".
  static std::string place_of(const testing::Check& check) {
    std::string_view place = check.name;
    if (place.starts_with(check.law)) place.remove_prefix(check.law.size());
    while (place.starts_with(' ')) place.remove_prefix(1);
    return place.empty() ? "" : std::string(place) + ": ";
  }

  static Told together(const std::vector<const testing::Check*>& of_law) {
    for (const testing::Check* check : of_law) {
      try {
        check->body();
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& error) {
        throw std::runtime_error(place_of(*check) + error.what());
      } catch (...) {
        throw std::runtime_error(place_of(*check) + "an exception that is no std::exception");
      }
    }
    return {};
  }

  // ---- the file
  // ----------------------------------------------------------------------------------

  bool file_is_sound() {
    const bool sound = look("file", "", {}, [&] {
      plugins::check_fingerprint(plugins::read_fingerprint(assignment_.file));
      return Told{};
    });
    if (!sound) return false;
    look("mathematics",
         "use somas::math, which gives the same bits on every CPU; sqrt, floor and the like are "
         "exact",
         {}, [&] { return imports(is_inexact, "takes from the C library: "); });
    look("clock and chance",
         "take chance from World::rng or the Rng handed in, and nothing from clocks or the "
         "process",
         {}, [&] { return imports(is_capricious, "may call: "); });
    const auto load = [&] {
      library_ = plugins::Library::open(assignment_.file);
      return Told{.text = library_->id() + " " + library_->version()};
    };
    if (!look("loads", "", {}, load)) return false;
    load();
    send({.kind = Message::Kind::library, .text = library_->id() + " " + library_->version()});
    return true;
  }

  Told imports(bool (*unwanted)(std::string_view), const std::string& text) const {
    std::vector<std::string> found;
    for (const std::string& name : plugins::imported_functions(assignment_.file))
      if (unwanted(name)) found.push_back(readable(name));
    if (found.empty()) return {};
    return {Verdict::warn, text + plugins::join(found)};
  }

  // ---- the classes
  // -------------------------------------------------------------------------------

  void look_at_classes() {
    try {
      for (const ClassInfo& info : library_->classes())
        making_[info.id] = {{library_, &info},
                            given_parameters(*library_, info, assignment_.settings)};
    } catch (const experiment::InputError& error) {
      send({.kind = Message::Kind::refused, .text = error.what()});
      return;
    }
    for (const ClassInfo& info : library_->classes()) look_at(info, making_[info.id]);
  }

  void look_at(const ClassInfo& info, const Making& making) {
    section_ = info.id;
    send({.kind = Message::Kind::section,
          .finding = {.section = section_},
          .text = plugins::kind_name(info.kind) + ": " + info.doc});
    look("docs", "say in `about` and `describe` what it is for: it is printed and documented", {},
         [&] { return documented(info); });
    const bool made = look("constructor", "construct from all that `describe` allows", {}, [&] {
      make(making);
      return Told{};
    });
    look("constructor at the limits",
         "narrow the range in `describe`, or throw ParameterError for what hangs on several "
         "parameters",
         {"constructor"}, [&] { return at_limits(making); });
    if (!made) return conclude_rest();
    switch (info.kind) {
      case PluginKind::environment:
        return look_at_environment(making);
      case PluginKind::specialization:
        return look_at_specialization(making);
      case PluginKind::controller:
        return look_at_controller(making);
      case PluginKind::fitness:
        return look_at_fitness(making);
    }
  }

  void conclude_rest() {
    look("everything else", "", {"constructor"}, [] { return Told{}; });
  }

  static Told documented(const ClassInfo& info) {
    std::vector<std::string> lacking = undocumented_in({info.parameters, info.parameter_count});
    if (std::string_view(info.doc).empty()) lacking.insert(lacking.begin(), "the class itself");
    if (!lacking.empty()) throw std::runtime_error("no doc: " + plugins::join(lacking));
    return {.text = plugins::plural(info.parameter_count, "parameter")};
  }

  static void make(const Making& making) {
    switch (making.plugin.info->kind) {
      case PluginKind::environment:
        static_cast<void>(make_environment(making));
        break;
      case PluginKind::specialization:
        static_cast<void>(make_specialization(making));
        break;
      case PluginKind::controller:
        static_cast<void>(make_controller(making));
        break;
      case PluginKind::fitness:
        static_cast<void>(make_fitness(making));
        break;
    }
  }

  Told at_limits(const Making& making) const {
    const std::vector<Variant> variants =
        variants_of(making.plugin.parameters(), making.parameters);
    std::size_t refused = 0;
    for (const Variant& variant : variants) {
      std::strncpy(page_.detail, variant.text.c_str(), sizeof page_.detail - 1);
      try {
        make({making.plugin, variant.values, false});
      } catch (const ParameterError&) {
        ++refused;  // its right: it may hang on others
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& error) {
        throw std::runtime_error(variant.text + ": " + error.what());
      } catch (...) {
        throw std::runtime_error(variant.text + ": an exception that is no std::exception");
      }
    }
    page_.detail[0] = 0;
    const std::string text = plugins::plural(variants.size(), "variant");
    return {.text = refused == 0 ? text : text + ", " + std::to_string(refused) + " refused"};
  }

  // ---- environments
  // ------------------------------------------------------------------------------

  /// Gives whatever is asked for, and notes it.
  class Asked final : public Connections {
   public:
    explicit Asked(Taps& taps) : taps_(taps) {}
    Variable vary(std::string_view instance, std::string_view parameter) override {
      constexpr VariableSpec spec{.value = 1};
      taps_.push_back({std::string(instance), std::string(parameter), spec});
      return {static_cast<Id>(taps_.size() - 1), spec};
    }

   private:
    Taps& taps_;
  };

  [[nodiscard]] static Taps taps_of(const Making& making) {
    Taps taps;
    testing::Declared declared;
    const std::unique_ptr<Environment> environment = make_environment(making);
    testing::TestDeclare declare(declared, testing::EnvironmentOptions{}.info, making.plugin.id());
    environment->declare(declare);
    Asked asked(taps);
    environment->connect(asked);
    return taps;
  }

  void look_at_environment(const Making& making) {
    const std::string connects = "declare and connect";
    const bool connected =
        look(connects,
             "declare from the parameters and Declare::world() alone, each "
             "name once; what is thrown ends the loading of an experiment",
             {}, [&] {
               const Taps taps = taps_of(making);
               std::vector<std::string> names;
               for (const auto& tap : taps) names.push_back(tap.instance + "." + tap.name);
               return Told{.text = names.empty()
                                       ? ""
                                       : "sets " + plugins::join(names) + ": stand-ins are there"};
             });
    const Taps taps = connected ? taps_of(making) : Taps{};
    testing::EnvironmentOptions options;
    options.instance = making.plugin.id();
    options.variables = taps;
    look(testing::environment_checks([making] { return make_environment(making); }, options),
         {connects});
    look_in_host(making, taps, {connects, "declare", "a first simulation"});
    look("grids cover the world",
         "cells beyond a grid sense and find nothing there: make it cover Declare::world().radius, "
         "or say in the doc that this is meant",
         {connects}, [&] { return covered(making, options); });
    look("time", "", {connects, "a first simulation", "the host: lives"}, [&] {
      return Told{Verdict::info, time_of_environment(making, taps)};
    });
  }

  static Told covered(const Making& making, const testing::EnvironmentOptions& options) {
    const testing::EnvironmentStage stage(make_environment(making), options);
    std::vector<std::string> small;
    for (const testing::Declared::GridOf& grid : stage.declared().grids)
      if (grid.owner == options.instance && !model::covers(grid.spec, options.info.radius))
        small.push_back(grid.name);
    if (small.empty()) return {};
    return {Verdict::warn, "do not cover a world of radius 60: " + plugins::join(small)};
  }

  // ---- the other kinds
  // ---------------------------------------------------------------------------

  static const std::vector<SkillInfo>& skills() {
    static const model::Schema schema = [] {
      model::Schema all = model::core_schema();
      for (const std::string_view name : usual_skills)
        all.skills.push_back({std::string(name), {}});
      return all;
    }();
    static const std::vector<SkillInfo> infos = schema.skill_infos();
    return infos;
  }

  void look_at_specialization(const Making& making) {
    look(testing::specialization_checks([making] { return make_specialization(making); }, skills()),
         {});
    look_in_host(making, {}, {"declare", "grow", "random and mutate", "grow after mutations"});
    look("time", "", {"declare", "grow", "the host: lives"}, [&] {
      return Told{Verdict::info, time_of_specialization(making, skills())};
    });
  }

  void look_at_controller(const Making& making) {
    look(testing::controller_checks([making] { return make_controller(making); }), {});
    look_in_host(making, {}, {"random and mutate", "step"});
    look("time", "", {"random and mutate", "step", "the host: lives"}, [&] {
      return Told{Verdict::info, time_of_controller(making)};
    });
  }

  void look_at_fitness(const Making& making) {
    look(testing::fitness_checks([making] { return make_fitness(making); }), {});
    look_in_host(making, {}, {"declare", "objective", "score", "observe"});
    look("time", "", {"declare", "observe", "the host: lives"}, [&] {
      return Told{Verdict::info, time_of_fitness(making)};
    });
  }

  /// Lives in the host differ wherever the checks before found that lives differ.
  void look_in_host(const Making& making, const Taps& taps, std::vector<std::string> needs) {
    testing::Checks checks = host_checks(making, taps);
    for (const char* law :
         {"a second instance, the same seed", "a second simulation of one instance",
          "two instances in turns", "one instance serving two worlds in turns", "saved in mid-life",
          "another storage order of the cells", "chance from the stream alone",
          "a second run of one program", "cells in other lanes", "express by a second instance"})
      for (testing::Check& check : checks)
        if (!check.first) check.needs.emplace_back(law);
    look(checks, std::move(needs));
  }

  Assignment assignment_;
  Page& page_;
  std::map<std::string, Verdict> done_;
  std::string section_;
  std::shared_ptr<const plugins::Library> library_;
  std::map<std::string, Making> making_;
};

// ---- the process
// ---------------------------------------------------------------------------------

[[noreturn]] void leave_by_terminate() {
  // std::bad_alloc may have met a noexcept.
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    leave(examiner_no_memory);
  } catch (...) {
  }
  std::abort();
}

// Dies with its parent, leaves no core dump, and keeps within its memory.
void settle(const Assignment& assignment) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != assignment.parent) leave(0);
  std::signal(SIGPIPE, SIG_IGN);
  // A crash is a crash, whatever a sanitizer or a parent would make of it.
  for (const int crash : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) std::signal(crash, SIG_DFL);
  std::set_terminate(leave_by_terminate);
  // At once, while it is known whose call asks for memory.
  std::set_new_handler([] { leave(examiner_no_memory); });
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // Sanitizers need memory without a limit.
  const rlimit memory{assignment.memory_mib << 20, assignment.memory_mib << 20};
  if (assignment.memory_mib != 0) ::setrlimit(RLIMIT_DATA, &memory);
#endif
  // When the machine's memory ends, better this process than another.
  std::ofstream("/proc/self/oom_score_adj") << 500;
}

template <class Number>
Number number_of(const std::string& text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

Assignment assignment_of(const std::vector<std::string>& words) {
  Assignment assignment;
  assignment.parent = number_of<int>(words[0]);
  assignment.memory_mib = number_of<std::uint64_t>(words[1]);
  assignment.file = words[2];
  for (std::size_t i = 3; i + 1 < words.size(); i += 2)
    (words[i] == "set" ? assignment.settings : assignment.done).push_back(words[i + 1]);
  return assignment;
}

}  // namespace

std::vector<std::string> words_of(const Assignment& assignment) {
  std::vector<std::string> words = {std::to_string(assignment.parent),
                                    std::to_string(assignment.memory_mib), assignment.file};
  for (const std::string& setting : assignment.settings) {
    words.emplace_back("set");
    words.push_back(setting);
  }
  for (const std::string& entry : assignment.done) {
    words.emplace_back("done");
    words.push_back(entry);
  }
  return words;
}

void examine(const std::vector<std::string>& words) {
  if (words.size() < 3) {
    std::fputs("somas-host: examiners are started by a check, not by hand\n", stderr);
    std::exit(2);
  }
  const Assignment assignment = assignment_of(words);
  settle(assignment);
  void* memory =
      ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, examiner_page, 0);
  if (memory == MAP_FAILED) leave(examiner_no_memory);
  // Its bytes are zeroes, which is a valid value.
  auto* page = static_cast<Page*>(memory);
  watch_calls(&page->site);
  try {
    Examination(assignment, *page).run();
  } catch (const std::bad_alloc&) {
    leave(examiner_no_memory);
  }
  // Not by way of the plugin's destructors.
  leave(0);
}

}  // namespace somas::conformance
