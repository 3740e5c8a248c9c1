// The subcommands: their arguments and what runs them. Each returns an exit code or throws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/host/backend_choice.hpp"
#include "core/run/terminal.hpp"

namespace somas::host {

/// somas-host [run] FILE
struct RunCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;  ///< --set, then --seed and --generations
  std::vector<std::filesystem::path> plugin_path;
  std::optional<std::filesystem::path> out;
  std::vector<std::filesystem::path> genomes;
  BackendChoice backend;
  bool profile = false;
  bool quiet = false;
  std::vector<std::string> command_line;
  std::vector<std::string> sweeps;  ///< --sweep
  bool single = false;              ///< without the file's replicates and sweep
  bool dry_run = false;
  std::uint64_t at_once = 0;  ///< --runs-at-once; 0: as many as keep the evaluators busy
};

/// somas-host resume RUN
struct ResumeCommand {
  std::filesystem::path run;  ///< or a campaign
  std::optional<std::uint64_t> replicates;
  std::vector<std::string> sweeps;
  std::uint64_t at_once = 0;
  std::optional<std::uint64_t> generations;
  bool accept_changes = false;
  std::vector<std::filesystem::path> plugin_path;
  BackendChoice backend;
  bool quiet = false;
};

/// somas-host dump RUN
struct DumpCommand {
  std::filesystem::path run;
  bool hash = false;
};

/// somas-host validate FILE
struct ValidateCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  std::vector<std::string> sweeps;
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

/// somas-host new KIND NAME DIR
struct NewCommand {
  std::string kind;
  std::string name;
  std::filesystem::path directory;
};

/// somas-host check FILE.so
struct CheckCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;  ///< --set ID.parameter=VALUE
  unsigned seconds = 20;
  std::uint64_t memory_mib = 2048;
};

/// somas-host schema
struct SchemaCommand {
  std::vector<std::filesystem::path> plugin_path;
  std::optional<std::filesystem::path> out;
};

/// replay --picture FILE
struct PictureCommand {
  std::optional<std::filesystem::path> file;
  std::vector<std::uint64_t> steps;
  std::string grid;
  std::string view = "organism";
  std::uint32_t width = 1600;
};

/// replay --html FILE
struct PageCommand {
  std::optional<std::filesystem::path> file;
  std::optional<std::string> compare;          ///< RUN[:GENERATION], or a recording
  std::vector<std::string> compare_overrides;  ///< --compare-set
};

/// somas-host replay RUN
struct ReplayCommand {
  std::filesystem::path run;  ///< or a recording
  std::optional<std::uint64_t> generation;
  std::uint32_t population = 1;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  std::optional<std::filesystem::path> csv;
  bool anatomy = false;
  std::optional<std::filesystem::path> anatomy_csv;
  std::optional<std::uint64_t> from_step;
  std::optional<std::filesystem::path> from_state;
  std::vector<std::string> wounds;                  ///< X,Y,RADIUS
  bool save = false;                                ///< --save-state
  std::optional<std::filesystem::path> save_state;  ///< default: in RUN/states
  std::optional<std::uint64_t> at_step;
  PictureCommand picture;
  std::optional<std::filesystem::path> record;
  PageCommand page;
  std::optional<std::uint64_t> every, fields_every;  ///< of page and recording
  unsigned world_threads = 1;
};

/// somas-host compete FILE
struct CompeteCommand {
  std::filesystem::path file;
  std::vector<std::string> overrides;  ///< --set, then --seed
  std::vector<std::filesystem::path> plugin_path;
  std::vector<std::filesystem::path> genomes;
  bool random = false;
  std::uint32_t seeds = 30;
  unsigned threads = 0;
  std::optional<std::filesystem::path> csv;
};

/// somas-host export FILE
struct ExportCommand {
  std::filesystem::path file;
  std::string format;
  std::filesystem::path out;
};

/// somas-host render RUN...
struct RenderCommand {
  std::vector<std::filesystem::path> runs;
  std::string what;
  std::optional<std::uint64_t> generation;
  std::uint32_t population = 1;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  std::vector<std::string> steps;  ///< N, or FIRST:LAST:DISTANCE
  std::string grid;
  std::string view = "organism";
  std::uint32_t columns = 0;
  std::string format;  ///< default: that of `out`, else svg
  std::optional<std::filesystem::path> out;
  double width = 0;  ///< millimetres; 0: by the figure
  double dpi = 300;
};

/// somas-host movie RUN
struct MovieCommand {
  std::filesystem::path run;
  std::optional<std::uint64_t> generation;
  std::uint32_t population = 1;
  std::vector<std::string> overrides;
  std::vector<std::filesystem::path> plugin_path;
  std::string grid;
  std::string view = "organism";
  std::optional<std::filesystem::path> out;
  double fps = 25;
  std::uint64_t every = 0;  ///< steps a frame; 0: at most 600 frames
  std::uint32_t width = 960;
};

/// Nothing to run: --help and --version have answered.
struct Done {
  int exit_code = 0;
};

using Command =
    std::variant<Done, RunCommand, ValidateCommand, PluginsCommand, DescribeCommand, NewCommand,
                 SchemaCommand, ReplayCommand, CompeteCommand, ResumeCommand, DumpCommand,
                 RenderCommand, MovieCommand, ExportCommand, CheckCommand>;

int execute(const RunCommand& command, run::Terminal& terminal);
int execute(const ResumeCommand& command, run::Terminal& terminal);
int execute(const DumpCommand& command, run::Terminal& terminal);
int execute(const ValidateCommand& command, run::Terminal& terminal);
int execute(const PluginsCommand& command, run::Terminal& terminal);
int execute(const DescribeCommand& command, run::Terminal& terminal);
int execute(const NewCommand& command, run::Terminal& terminal);
int execute(const SchemaCommand& command, run::Terminal& terminal);
int execute(const ReplayCommand& command, run::Terminal& terminal);
int execute(const CompeteCommand& command, run::Terminal& terminal);
int execute(const ExportCommand& command, run::Terminal& terminal);
int execute(const RenderCommand& command, run::Terminal& terminal);
int execute(const MovieCommand& command, run::Terminal& terminal);
int execute(const CheckCommand& command, run::Terminal& terminal);

/// Writes to the standard output. Throws run::WriteError.
void print(const std::string& text);

}  // namespace somas::host
