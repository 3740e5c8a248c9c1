#include "core/run/profile_report.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string_view>

#include <sys/resource.h>

#include "core/run/files.hpp"
#include "core/run/json.hpp"

namespace somas::run {
namespace {

double seconds_of(model::Profile::Duration time) {
  return std::chrono::duration<double>(time).count();
}

std::uint64_t peak_memory_of_this_process() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

Json json_of(const ProfileReport::Part& part, const char* name) {
  Json json;
  json[name] = part.name;
  if (!part.call.empty()) json["call"] = part.call;
  json["seconds"] = part.seconds;
  json["share"] = part.share;
  if (part.calls > 0) json["calls"] = part.calls;
  return json;
}

void append_row(std::string& text, const std::string& name, const ProfileReport::Part& part,
                double cell_steps) {
  char row[160];
  std::snprintf(row, sizeof row, "  %-36s %9.3f s %5.1f %% %8.1f ns a cell-step\n", name.c_str(),
                part.seconds, 100 * part.share,
                cell_steps > 0 ? 1e9 * part.seconds / cell_steps : 0.0);
  text += row;
}

}  // namespace

ProfileReport report_on(const model::Profile& profile) {
  ProfileReport report;
  report.simulations = profile.lives();
  report.steps = profile.steps();
  report.cell_steps = profile.cell_steps();
  report.seconds = seconds_of(profile.total());
  report.cell_steps_per_second = report.seconds > 0 ? report.cell_steps / report.seconds : 0;
  report.peak_memory = peak_memory_of_this_process();
  const auto share = [&](double seconds) {
    return report.seconds > 0 ? seconds / report.seconds : 0;
  };
  for (std::size_t p = 0; p < model::step_phases; ++p) {
    const auto phase = static_cast<model::StepPhase>(p);
    const double seconds = seconds_of(profile.phase(phase));
    report.phases.push_back({std::string(name_of(phase)), {}, seconds, share(seconds), 0});
  }
  for (const model::Profile::Call& call : profile.calls()) {
    const double seconds = seconds_of(call.time);
    report.plugins.push_back({call.plugin, call.call, seconds, share(seconds), call.calls});
  }
  std::stable_sort(report.plugins.begin(), report.plugins.end(),
                   [](const auto& a, const auto& b) { return a.seconds > b.seconds; });
  return report;
}

void write_profile(const std::filesystem::path& run, const ProfileReport& report) {
  Json json;
  json["format"] = "somas-profile/1";
  json["simulations"] = report.simulations;
  json["steps"] = report.steps;
  json["cell_steps"] = report.cell_steps;
  json["seconds"] = report.seconds;
  json["cell_steps_per_second"] = report.cell_steps_per_second;
  json["peak_memory"] = report.peak_memory;
  json["phases"] = Json::array();
  for (const ProfileReport::Part& part : report.phases)
    json["phases"].push_back(json_of(part, "phase"));
  json["plugins"] = Json::array();
  for (const ProfileReport::Part& part : report.plugins)
    json["plugins"].push_back(json_of(part, "plugin"));
  write_file(run / "profile.json", to_text(json));
}

std::string to_text(const ProfileReport& report) {
  char line[200];
  std::snprintf(
      line, sizeof line,
      "%llu simulations, %llu steps, %.4g cell-steps in %.3f s: %.3g million cell-steps a "
      "second of a thread; peak memory %.0f MiB\n",
      static_cast<unsigned long long>(report.simulations),
      static_cast<unsigned long long>(report.steps), report.cell_steps, report.seconds,
      report.cell_steps_per_second / 1e6,
      static_cast<double>(report.peak_memory) / (1024.0 * 1024.0));
  std::string text = line;
  text += "phases of the step:\n";
  for (const ProfileReport::Part& part : report.phases)
    append_row(text, part.name, part, report.cell_steps);
  text += "plugins, within them:\n";
  for (const ProfileReport::Part& part : report.plugins)
    append_row(text, part.name + ", " + part.call, part, report.cell_steps);
  return text;
}

}  // namespace somas::run
