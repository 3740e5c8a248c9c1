// The subcommands: their arguments and what runs them. Each returns an exit code or throws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/run/terminal.hpp"

namespace somas::host {

/// somas-host [run] FILE
struct RunCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;  ///< --set, then --seed and --generations
  std::vector<std::filesystem::path> plugin_path;
  std::optional<std::filesystem::path> out;
  std::vector<std::filesystem::path> genomes;
  unsigned threads = 0;
  bool quiet = false;
  std::vector<std::string> command_line;
};

/// somas-host validate FILE
struct ValidateCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  bool show_resolved = false;
};

/// somas-host plugins
struct PluginsCommand {
  std::vector<std::filesystem::path> plugin_path;
};

/// somas-host describe ID
struct DescribeCommand {
  std::string id;
  std::string format = "text";
  std::vector<std::filesystem::path> plugin_path;
};

/// replay --picture FILE
struct PictureCommand {
  std::optional<std::filesystem::path> file;
  std::vector<std::uint64_t> steps;
  std::string grid;
  std::string view = "organism";
  std::uint32_t width = 1600;
};

/// somas-host replay RUN
struct ReplayCommand {
  std::filesystem::path run;
  std::optional<std::uint64_t> generation;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  std::optional<std::filesystem::path> csv;
  bool anatomy = false;
  std::optional<std::filesystem::path> anatomy_csv;
  PictureCommand picture;
};

/// Nothing to run: --help and --version have answered.
struct Done {
  int exit_code = 0;
};

using Command =
    std::variant<Done, RunCommand, ValidateCommand, PluginsCommand, DescribeCommand, ReplayCommand>;

int execute(const RunCommand& command, run::Terminal& terminal);
int execute(const ValidateCommand& command, run::Terminal& terminal);
int execute(const PluginsCommand& command, run::Terminal& terminal);
int execute(const DescribeCommand& command, run::Terminal& terminal);
int execute(const ReplayCommand& command, run::Terminal& terminal);

/// Writes to the standard output. Throws run::WriteError.
void print(const std::string& text);

}  // namespace somas::host
