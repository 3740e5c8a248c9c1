#include "tests/faults/processes.hpp"

#include <algorithm>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <sstream>
#include <unistd.h>

namespace somas::test {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(pid_t process) { return "/proc/" + std::to_string(process); }

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

pid_t start(const std::vector<std::string>& words, const fs::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::setpgid(0, 0);
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

std::vector<pid_t> children_of(pid_t process) {
  std::vector<pid_t> children;
  std::error_code error;
  for (const auto& task : fs::directory_iterator(folder_of(process) / "task", error)) {
    std::istringstream in(text_of(task.path() / "children"));
    for (pid_t child = 0; in >> child;) children.push_back(child);
  }
  std::sort(children.begin(), children.end());
  return children;
}

bool alive(pid_t process) {
  // "123 (name) S ...": the name may hold anything.
  const std::string stat = text_of(folder_of(process) / "stat");
  const std::size_t end = stat.rfind(')');
  return end != std::string::npos && end + 2 < stat.size() && stat[end + 2] != 'Z';
}

int rank_of(pid_t process) {
  const std::string environment = text_of(folder_of(process) / "environ");
  const std::string name = "OMPI_COMM_WORLD_RANK=";
  const std::size_t begin = environment.find(name);
  return begin == std::string::npos ? -1 : std::stoi(environment.substr(begin + name.size()));
}

std::string phase_of(pid_t coordinator) {
  std::string phase = "start or end";
  std::error_code error;
  for (const auto& task : fs::directory_iterator(folder_of(coordinator) / "task", error)) {
    std::string name = text_of(task.path() / "comm");
    if (!name.empty()) name.pop_back();
    for (const char* known : {"select", "evaluate", "commit", "export"})
      if (name == known) phase = name;
  }
  return phase;
}

}  // namespace somas::test
