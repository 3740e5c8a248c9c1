#include <cstdint>
#include <optional>
#include <string>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/report/export.hpp"
#include "core/run/signals.hpp"

namespace somas::host {
namespace {

constexpr int exit_of_signal = 128;

report::ExportFormat format_of(const std::string& name) {
  if (name == "csv") return report::ExportFormat::csv;
  return name == "vtp" ? report::ExportFormat::vtp : report::ExportFormat::xyz;
}

}  // namespace

int execute(const ExportCommand& command, run::Terminal&) {
  const run::SignalGuard signals;
  const std::optional<std::uint64_t> frames = report::export_recording(
      command.file, format_of(command.format), command.out, signals.token());
  if (!frames) return exit_of_signal + run::SignalGuard::received();
  print(command.out.string() + ": " + std::to_string(*frames) + " frames\n");
  return exit_ok;
}

}  // namespace somas::host
