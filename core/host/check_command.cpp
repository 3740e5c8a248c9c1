#include <filesystem>
#include <string>

#include "core/conformance/supervisor.hpp"
#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/errors.hpp"

namespace somas::host {
namespace {

using conformance::Finding;
using conformance::Message;

std::string line_of(const Finding& finding) {
  std::string text = "  " + std::string(conformance::name_of(finding.verdict)) + "  " + finding.law;
  if (!finding.text.empty()) text += ": " + finding.text;
  text += "\n";
  if (!finding.remedy.empty()) text += "        remedy: " + finding.remedy + "\n";
  return text;
}

void tell(const Message& message) {
  if (message.kind == Message::Kind::section)
    print("\n" + message.finding.section + " (" + message.text + ")\n");
  if (message.kind == Message::Kind::end) print(line_of(message.finding));
}

std::string summary_of(const conformance::Tally& tally) {
  std::string text = std::to_string(tally.passed) + " passed";
  if (tally.warned > 0) text += ", " + plugins::plural(tally.warned, "warning");
  text += ", " + std::to_string(tally.failed) + " failed";
  if (tally.skipped > 0) text += ", " + std::to_string(tally.skipped) + " skipped";
  return "\n" + text + "\n";
}

}  // namespace

int execute(const CheckCommand& command, run::Terminal&) {
  if (!std::filesystem::exists(command.file))
    throw run::UsageError(command.file.string() + ": no such file");
  try {
    print(command.file.string() + "\n");
    const conformance::Tally tally =
        conformance::examine_plugin({.program = "/proc/self/exe",
                                     .file = command.file,
                                     .settings = command.overrides,
                                     .seconds = static_cast<double>(command.seconds),
                                     .memory_mib = command.memory_mib},
                                    tell);
    print(summary_of(tally));
    return tally.failed == 0 ? exit_ok : exit_plugin_failed;
  } catch (const conformance::RefusedSetting& error) {
    throw run::UsageError(error.what());
  }
}

}  // namespace somas::host
