#include "core/conformance/report.hpp"

#include <stdexcept>

namespace somas::conformance {
namespace {

constexpr Verdict verdicts[] = {Verdict::pass, Verdict::warn, Verdict::fail, Verdict::skip,
                                Verdict::info};

std::string one_line(std::string_view text) {
  std::string line(text);
  for (char& c : line)
    if (c == '\n' || c == '\t' || c == '\r') c = ' ';
  return line;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::warn:
      return "warn";
    case Verdict::fail:
      return "FAIL";
    case Verdict::skip:
      return "skip";
    case Verdict::info:
      return "info";
  }
  return "";
}

Verdict verdict_named(std::string_view name) {
  for (const Verdict verdict : verdicts)
    if (name_of(verdict) == name) return verdict;
  throw std::runtime_error("no verdict: " + std::string(name));
}

std::string encode(const Message& message) {
  const Finding& f = message.finding;
  std::string line(1, static_cast<char>(message.kind));
  for (const std::string_view part :
       {std::string_view(f.section), std::string_view(f.law), name_of(f.verdict),
        std::string_view(f.text), std::string_view(f.remedy), std::string_view(message.text)})
    line += "\t" + one_line(part);
  return line + "\n";
}

Message decode(std::string_view line) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = line.find('\t');
    parts.emplace_back(line.substr(0, end));
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  if (parts.size() != 7 || parts[0].size() != 1) throw std::runtime_error("a damaged line");
  Message message;
  message.kind = static_cast<Message::Kind>(parts[0][0]);
  message.finding = {parts[1], parts[2], verdict_named(parts[3]), parts[4], parts[5]};
  message.text = parts[6];
  return message;
}

}  // namespace somas::conformance
