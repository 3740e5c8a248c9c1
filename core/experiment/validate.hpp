// Checks a Node tree against parameter descriptions and turns it into values.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/experiment/node.hpp"
#include "core/plugins/values.hpp"

namespace somas::experiment {

/// Collects what is wrong, so that one reading reports several faults.
class Problems {
 public:
  void add(const Position& position, const std::string& path, const std::string& message);
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// Throws one InputError with all of them (the first ten), a line each; nothing when there are
  /// none.
  void raise() const;

 private:
  struct Problem {
    Position position;
    std::string message;
  };
  std::vector<Problem> problems_;
};

/// "a.b" from "a" and "b".
[[nodiscard]] std::string joined(const std::string& path, const std::string& key);

class Validator {
 public:
  explicit Validator(Problems& problems) : problems_(problems) {}

  /// The group that `mapping` gives for `fields`: what it leaves out comes from `base` if there is
  /// one, else from the fields' defaults. Keys in `handled` are the caller's. Faults are collected;
  /// a faulty field has its default.
  [[nodiscard]] plugins::ParameterValue group(std::span<const ParameterInfo> fields,
                                              const Node& mapping, const std::string& path,
                                              std::span<const std::string> handled = {},
                                              const plugins::ParameterValue* base = nullptr);

  /// A scalar that must be a text; nullopt (and a problem) when it is not.
  [[nodiscard]] std::optional<std::string> text(const Node& node, const std::string& path);

  /// Adds a problem and returns false unless the node is a mapping.
  bool expect_mapping(const Node& node, const std::string& path);

 private:
  using Read = std::optional<plugins::ParameterValue>;

  Read value(const ParameterInfo& info, const Node& node, const std::string& path,
             const plugins::ParameterValue* base);
  Read number(const ParameterInfo& info, const Node& node, const std::string& path);
  Read integer(const ParameterInfo& info, const Node& node, const std::string& path);
  Read boolean(const Node& node, const std::string& path);
  Read choice(const ParameterInfo& info, const Node& node, const std::string& path);
  Read list(const ParameterInfo& info, const Node& node, const std::string& path,
            const plugins::ParameterValue* base);
  Read patched_list(const ParameterInfo& info, const Node& node, const std::string& path,
                    const plugins::ParameterValue* base);
  Read table(const ParameterInfo& info, const Node& node, const std::string& path);

  void relations(std::span<const ParameterInfo> fields, const Node& mapping,
                 const std::string& path, const plugins::ParameterValue& group,
                 std::span<const std::string> faulty);
  void wrong(const Node& node, const std::string& path, const std::string& expected,
             const std::string& hint = {});
  [[nodiscard]] bool is_plain_scalar(const Node& node, const std::string& path,
                                     const std::string& expected);
  void out_of_range(const ParameterInfo& info, const Node& node, const std::string& path);

  Problems& problems_;
};

}  // namespace somas::experiment
