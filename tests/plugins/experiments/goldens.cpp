// goldens [--why TEXT]
//
// Compares the golden hashes with what this build comes to, and says what differs: exit code 1.
// With a reason the file is written anew, the reason in it.
#include "tests/plugins/experiments/goldens.hpp"

#include <cstdio>
#include <exception>

namespace somas::test {
namespace {

constexpr std::string_view head =
    "# What short runs of the shipped experiments come to, to the last bit, with any number of\n"
    "# threads and any instruction set. `./dev goldens` compares; `./dev goldens --why TEXT` "
    "alone\n"
    "# changes the file. Why it is as it is, the latest reason last:\n";

std::string reasons_in(const std::string& text) {
  std::string reasons;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("# why: ")) reasons += line + "\n";
  return reasons;
}

int compare(const std::string* why) {
  const std::string old =
      std::filesystem::exists(goldens_file) ? run::read_file(goldens_file) : std::string();
  const auto before = read_goldens(old);
  std::string lines;
  int differences = 0;
  for (const std::string& name : golden_names()) {
    const std::string now = golden_of(name, 1);
    lines += name + " " + now + "\n";
    const auto known = before.find(name);
    if (known != before.end() && known->second == now) continue;
    ++differences;
    std::printf("%s: %s\n  now %s\n", name.c_str(),
                known == before.end() ? "new" : known->second.c_str(), now.c_str());
  }
  std::printf("%d of %zu differ\n", differences, golden_names().size());
  if (why == nullptr) return differences == 0 ? 0 : 1;
  if (read_goldens(lines) == before) return 0;
  run::write_file(goldens_file,
                  std::string(head) + reasons_in(old) + "# why: " + *why + "\n" + lines);
  std::printf("written, because: %s\n", why->c_str());
  return 0;
}

int main_of(const std::vector<std::string>& arguments) {
  if (arguments.empty()) return compare(nullptr);
  const bool valid = arguments.size() == 2 && arguments[0] == "--why" && !arguments[1].empty() &&
                     arguments[1].find('\n') == std::string::npos;
  if (valid) return compare(&arguments[1]);
  std::fprintf(stderr, "usage: goldens [--why TEXT], the text on one line\n");
  return 2;
}

}  // namespace
}  // namespace somas::test

int main(int argc, char** argv) {
  try {
    return somas::test::main_of({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "goldens: %s\n", error.what());
    return 1;
  }
}
