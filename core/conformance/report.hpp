// What an examination of a plugin file finds, as values and as lines between two processes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/call_site.hpp"

namespace somas::conformance {

enum class Verdict { pass, warn, fail, skip, info };

[[nodiscard]] std::string_view name_of(Verdict verdict);  ///< "pass", "FAIL"
/// The inverse. Throws std::runtime_error.
[[nodiscard]] Verdict verdict_named(std::string_view name);

/// One line of the report.
struct Finding {
  std::string section{};  ///< id of the class; empty: about the file
  std::string law{};      ///< what was looked at
  Verdict verdict = Verdict::pass;
  std::string text{};    ///< what is wrong, or what there is to know; may be empty
  std::string remedy{};  ///< what to do about it; empty: nothing, or `text` says it
};

/// What an examiner says, in the order of happening.
struct Message {
  enum class Kind : char {
    library = 'L',  ///< text: id and version
    section = 'S',  ///< finding.section; text: kind and doc
    begin = 'B',    ///< of a law: finding.section, finding.law
    end = 'E',      ///< the finding
    refused = 'R',  ///< text: what is wrong with --set
    over = 'O',     ///< nothing is left to look at
  };
  Kind kind = Kind::over;
  Finding finding{};
  std::string text{};
};

/// One line with its end; line breaks and tabulators of the texts become spaces.
[[nodiscard]] std::string encode(const Message& message);
/// The inverse, without the line's end. Throws std::runtime_error.
[[nodiscard]] Message decode(std::string_view line);

/// Memory that examiner and supervisor share, so that the latter can tell what the former did when
/// it died. Zeroes are a valid value.
struct Page {
  model::CallSite site;
  char detail[200];  ///< which variant of the parameters is looked at; empty: those given
};

/// The first word of an examiner's command line; no subcommand for people.
inline constexpr const char* examiner_command = "examiner-process";
inline constexpr int examiner_pipe = 3;  ///< descriptors of the examiner
inline constexpr int examiner_page = 4;
inline constexpr int examiner_no_memory = 76;  ///< exit code after std::bad_alloc

}  // namespace somas::conformance
