#include "core/host/replay_page.hpp"

#include <charconv>
#include <cstdio>

#include "core/plugins/suggest.hpp"
#include "core/recording/file.hpp"
#include "core/report/page.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/replay.hpp"
#include "core/run/run_directory.hpp"

namespace somas::host {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> changes_of(const ReplayCommand& command) {
  std::vector<std::string> changes = command.overrides;
  const std::string from = command.from_step    ? " from step " + std::to_string(*command.from_step)
                           : command.from_state ? " from a saved state"
                                                : "";
  if (!changes.empty()) changes.back() += from;
  for (const std::string& wound : command.wounds) changes.push_back("wound " + wound + from);
  return changes;
}

std::string size_text(std::size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

}  // namespace

ReplayPage::ReplayPage(const ReplayCommand& command)
    : command_(command), other_(other()), life_({.changes = changes_of(command)}) {}

run::Recipient ReplayPage::recipient(report::PageData& life) const {
  return {.sink = &life,
          .every = command_.every.value_or(1),
          .fields_every = command_.fields_every.value_or(1),
          .controller = true};
}

// A colon may stand in a directory's name, too.
std::optional<ReplayPage::Other> ReplayPage::other() const {
  const PageCommand& page = command_.page;
  if (!page.compare) {
    if (page.compare_overrides.empty()) return std::nullopt;
    return Other{command_.run, command_.generation, command_.population};
  }
  std::error_code error;
  const std::string& text = *page.compare;
  if (fs::is_directory(text, error)) return Other{text, std::nullopt};
  if (fs::is_regular_file(text, error)) {
    if (!page.compare_overrides.empty())
      throw run::UsageError("--compare-set changes a life that is lived again; " + text +
                            " is a recording");
    return Other{text, std::nullopt};
  }
  const std::size_t colon = text.rfind(':');
  const char* end = text.data() + text.size();
  std::uint64_t generation = 0;
  const bool numbered = colon != std::string::npos && colon + 1 < text.size() &&
                        std::from_chars(text.data() + colon + 1, end, generation).ptr == end;
  const std::string run = numbered ? text.substr(0, colon) : text;
  if (!fs::is_directory(run.empty() ? command_.run : fs::path(run), error))
    throw run::UsageError("--compare: '" + text +
                          "' is not RUN, RUN:GENERATION or a recording: there "
                          "is no directory " +
                          run);
  return Other{run.empty() ? command_.run : fs::path(run), generation};
}

bool ReplayPage::replay(const Other& other, report::PageData& life, run::Terminal& terminal) {
  if (!fs::is_directory(other.run)) {
    recording::read(other.run, life);
    return true;
  }
  const run::ReplayReport replayed = run::replay({.run = other.run,
                                                  .generation = other.generation,
                                                  .population = other.population,
                                                  .overrides = command_.page.compare_overrides,
                                                  .plugin_directories = command_.plugin_path,
                                                  .observer = {},
                                                  .recipients = {recipient(life)},
                                                  .from_step = {},
                                                  .from_state = {},
                                                  .wounds = {},
                                                  .save_at = {}});
  for (const std::string& warning : replayed.warnings) terminal.line("warning: " + warning);
  print("compared with " + to_text(replayed));
  return replayed.matches();
}

bool ReplayPage::write(run::Terminal& terminal) {
  std::vector<std::string> lives{life_.bytes()};
  std::string frames = plugins::plural(life_.frames(), "frame");
  bool reproduced = true;
  if (other_) {
    report::PageData life({.changes = command_.page.compare_overrides});
    reproduced = replay(*other_, life, terminal);
    lives.push_back(life.bytes());
    frames += " and " + plugins::plural(life.frames(), "frame");
  }
  const std::string page = report::build_page(lives);
  run::write_output(*command_.page.file, page);
  print("page: " + command_.page.file->string() + ", " + frames + ", " + size_text(page.size()) +
        "\n");
  return reproduced;
}

}  // namespace somas::host
