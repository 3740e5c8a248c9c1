#include <map>

#include "core/host/commands.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/installation.hpp"
#include "core/plugins/project.hpp"
#include "core/plugins/registry.hpp"
#include "core/run/errors.hpp"

namespace somas::host {
namespace {

const std::map<std::string, PluginKind> kinds = {
    {"environment", PluginKind::environment},
    {"specialization", PluginKind::specialization},
    {"controller", PluginKind::controller},
    {"fitness", PluginKind::fitness},
};

// Two plugins of one id could not be used together.
void refuse_known_id(const std::string& name) {
  const plugins::Registry registry(plugins::standard_search_path());
  for (const plugins::Candidate& candidate : registry.candidates())
    if (candidate.library != nullptr)
      for (const ClassInfo& info : candidate.library->classes())
        if (info.id == name)
          throw run::UsageError("there is a plugin '" + name +
                                "' already: " + candidate.file.string() + "; choose another name");
}

// As a shell takes it.
std::string quoted(const std::string& text) {
  const bool plain = text.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789/._-+") == std::string::npos;
  if (plain && !text.empty()) return text;
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string next_steps(const NewCommand& command) {
  const std::string directory = quoted(command.directory.string());
  const std::string prefix = quoted(plugins::prefix_directory().string());
  return "next:\n  cd " + directory + "\n  cmake -S . -B build -DCMAKE_PREFIX_PATH=" + prefix +
         "\n  cmake --build build\n  ctest --test-dir build\n  " +
         quoted((plugins::executable_directory() / "somas-host").string()) + " " + command.name +
         ".yaml\n";
}

}  // namespace

int execute(const NewCommand& command, run::Terminal&) {
  try {
    plugins::check_project_name(command.name);
    refuse_known_id(command.name);
    const std::vector<std::filesystem::path> files =
        plugins::write_project(kinds.at(command.kind), command.name, command.directory,
                               plugins::share_directory() / "template");
    std::string text = command.directory.string() + ":\n";
    for (const std::filesystem::path& file : files) text += "  " + file.string() + "\n";
    print(text + next_steps(command));
  } catch (const plugins::ProjectError& error) {
    throw run::UsageError(error.what());
  }
  return exit_ok;
}

}  // namespace somas::host
