#include "core/experiment/validate.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/plugins/relations.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/yaml_text.hpp"

namespace somas::experiment {

using plugins::ParameterValue;

namespace {

// The sign '+' is YAML's, but not std::from_chars's.
std::string_view without_plus(std::string_view text) {
  const bool signed_number = text.size() > 1 && text[0] == '+' && text[1] != '-';
  return signed_number ? text.substr(1) : text;
}

struct ParsedNumber {
  bool is_number = false;
  bool overflows = false;
  double number = 0;
};

ParsedNumber parse_number(std::string_view text) {
  text = without_plus(text);
  ParsedNumber parsed;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed.number);
  parsed.is_number = error != std::errc::invalid_argument && end == text.data() + text.size();
  parsed.overflows = error == std::errc::result_out_of_range;
  return parsed;
}

// YAML writes .nan and .inf; people also write nan and Infinity, which from_chars takes.
bool is_not_finite(std::string_view text) {
  text = without_plus(text);
  std::string word(text.starts_with('-') ? text.substr(1) : text);
  if (word.starts_with('.')) word.erase(0, 1);
  std::transform(word.begin(), word.end(), word.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return word == "nan" || word == "inf" || word == "infinity";
}

bool is_integer_text(std::string_view text) {
  text = without_plus(text);
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Plain words that look like something else than a text.
bool looks_typed(const std::string& text) {
  return parse_number(text).is_number || is_not_finite(text) || text == "true" || text == "false";
}

std::vector<std::string> names_of(std::span<const ParameterInfo> fields) {
  std::vector<std::string> names;
  for (const ParameterInfo& field : fields) names.emplace_back(field.name);
  return names;
}

// The range, with the ends of the type where it has none.
std::string most_of(const ParameterInfo& info) {
  using Limits64 = std::numeric_limits<std::int64_t>;
  if (std::isfinite(info.maximum)) return plugins::range_text(info);
  const std::string least = std::isfinite(info.minimum) ? plugins::format_number(info.minimum)
                                                        : std::to_string(Limits64::min());
  return least + " to " + std::to_string(Limits64::max());
}

ParameterValue scalar(ParameterKind kind) {
  ParameterValue value;
  value.kind = kind;
  return value;
}

// "beta_max, 20 (exp.yaml:4:3)", "region, its default everywhere".
std::string told(const ParameterInfo& info, const Node& mapping, const std::string& path,
                 const ParameterValue& group) {
  std::string text = joined(path, info.name);
  const Node* node = mapping.find(info.name);
  const ParameterValue* value = group.find(info.name);
  if (value == nullptr) return text + ", which is left out";
  if (plugins::is_inline(*value))
    text += ", " + std::string(node == nullptr ? "by default " : "") + plugins::yaml_inline(*value);
  return node == nullptr ? text : text + " (" + node->position.text() + ")";
}

std::string shown(const ParameterInfo& info, const ParameterValue& group) {
  const ParameterValue* value = group.find(info.name);
  return value != nullptr && plugins::is_inline(*value) ? plugins::yaml_inline(*value) : "it";
}

// What a broken relation is called, with both keys.
std::string message_of(const plugins::BrokenRelation& broken, const Node& mapping,
                       const std::string& path, const ParameterValue& group) {
  const std::string other = told(*broken.other, mapping, path, group);
  const std::string words = plugins::words_text(*broken.relation);
  switch (broken.relation->kind) {
    case RelationKind::at_most:
      return shown(*broken.first, group) + " is more than " + other + "; allowed: at most " +
             broken.other->name;
    case RelationKind::less_than:
      return shown(*broken.first, group) + " is not less than " + other + "; allowed: less than " +
             broken.other->name;
    case RelationKind::differs:
      return shown(*broken.first, group) + " is the same as " + other + "; the two must differ";
    case RelationKind::needs:
      return "needs " + other + "; give both or neither";
    case RelationKind::excludes:
      return "cannot stand beside " + other + "; give one of the two";
    case RelationKind::only_when:
      return "allowed only when " + std::string(broken.other->name) + " is " + words +
             "; there is " + other;
    case RelationKind::required_when:
      return "missing; required by " + other + ": " + broken.first->doc;
  }
  return {};
}

}  // namespace

std::string joined(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

// ---- problems ----------------------------------------------------------------------------------

void Problems::add(const Position& position, const std::string& path, const std::string& message) {
  problems_.push_back({position, path.empty() ? message : path + ": " + message});
}

void Problems::raise() const {
  constexpr std::size_t most = 10;
  if (problems_.empty()) return;
  std::string text = problems_[0].message;
  for (std::size_t i = 1; i < std::min(most, problems_.size()); ++i)
    text.append("\n")
        .append(problems_[i].position.text())
        .append(": ")
        .append(problems_[i].message);
  if (problems_.size() > most)
    text.append("\n(and ").append(std::to_string(problems_.size() - most)).append(" more)");
  throw InputError(problems_[0].position, text);
}

// ---- validator ---------------------------------------------------------------------------------

void Validator::wrong(const Node& node, const std::string& path, const std::string& expected,
                      const std::string& hint) {
  problems_.add(node.position, path,
                "expected " + expected + ", found " + node.description() + hint);
}

bool Validator::expect_mapping(const Node& node, const std::string& path) {
  if (node.kind == Node::Kind::mapping && !node.patch) return true;
  wrong(node, path, "a mapping",
        node.kind == Node::Kind::null ? "; write {} for all defaults" : "");
  return false;
}

bool Validator::is_plain_scalar(const Node& node, const std::string& path,
                                const std::string& expected) {
  if (node.kind == Node::Kind::scalar && !node.quoted) return true;
  const bool typed = node.kind == Node::Kind::scalar && looks_typed(node.text);
  wrong(node, path, expected, typed ? "; remove the quotes" : "");
  return false;
}

void Validator::out_of_range(const ParameterInfo& info, const Node& node, const std::string& path) {
  problems_.add(node.position, path,
                node.text + " is out of range; allowed: " + plugins::range_text(info));
}

ParameterValue Validator::group(std::span<const ParameterInfo> fields, const Node& mapping,
                                const std::string& path, std::span<const std::string> handled,
                                const ParameterValue* base) {
  // Unknown keys, and where they would have belonged.
  std::vector<std::string> allowed = names_of(fields);
  allowed.insert(allowed.end(), handled.begin(), handled.end());
  for (const Node& item : mapping.items)
    if (std::find(allowed.begin(), allowed.end(), item.key) == allowed.end())
      problems_.add(item.key_position, joined(path, item.key),
                    "unknown key; allowed: " + plugins::join(allowed) +
                        plugins::did_you_mean(item.key, allowed));

  ParameterValue result = scalar(ParameterKind::group);
  std::vector<std::string> faulty;
  for (const ParameterInfo& field : fields) {
    const Node* node = mapping.find(field.name);
    const ParameterValue* inherited = base != nullptr ? base->find(field.name) : nullptr;
    Read read;
    if (node != nullptr) read = value(field, *node, joined(path, field.name), inherited);
    if (node == nullptr && field.required != 0 && inherited == nullptr)
      problems_.add(mapping.key_position, joined(path, field.name),
                    "missing; expected " + plugins::kind_text(field) + ": " + field.doc);
    if (!read && (node != nullptr || (field.required != 0 && inherited == nullptr)))
      faulty.emplace_back(field.name);
    if (!read) read = inherited != nullptr ? *inherited : plugins::default_of(field);
    read->key = field.name;
    if (read->kind != ParameterKind::none) result.items.push_back(std::move(*read));
  }
  relations(fields, mapping, path, result, faulty);
  return result;
}

void Validator::relations(std::span<const ParameterInfo> fields, const Node& mapping,
                          const std::string& path, const ParameterValue& group,
                          std::span<const std::string> faulty) {
  plugins::find_broken(fields, group, [&](const plugins::BrokenRelation& broken) {
    // A field that is wrong by itself has been told already, and stands in with its default.
    const auto is_faulty = [&](const ParameterInfo& info) {
      return std::find(faulty.begin(), faulty.end(), info.name) != faulty.end();
    };
    if (is_faulty(*broken.first) || is_faulty(*broken.other)) return;
    const Node* place = mapping.find(broken.first->name);
    if (place == nullptr) place = mapping.find(broken.other->name);
    const bool on_key = place == nullptr || broken.relation->kind >= RelationKind::needs;
    if (place == nullptr) place = &mapping;
    problems_.add(on_key ? place->key_position : place->position, joined(path, broken.first->name),
                  message_of(broken, mapping, path, group));
  });
}

Validator::Read Validator::value(const ParameterInfo& info, const Node& node,
                                 const std::string& path, const ParameterValue* base) {
  switch (info.kind) {
    case ParameterKind::number:
      return number(info, node, path);
    case ParameterKind::integer:
      return integer(info, node, path);
    case ParameterKind::boolean:
      return boolean(node, path);
    case ParameterKind::choice:
      return choice(info, node, path);
    case ParameterKind::list:
      return list(info, node, path, base);
    case ParameterKind::table:
      return table(info, node, path);
    case ParameterKind::text: {
      const std::optional<std::string> read = text(node, path);
      if (!read) return {};
      ParameterValue result = scalar(ParameterKind::text);
      result.text = *read;
      return result;
    }
    case ParameterKind::group:
      if (!expect_mapping(node, path)) return {};
      return group(plugins::fields_of(info), node, path, {}, base);
    case ParameterKind::none:
      break;
  }
  return {};
}

Validator::Read Validator::number(const ParameterInfo& info, const Node& node,
                                  const std::string& path) {
  if (!is_plain_scalar(node, path, "a number")) return {};
  if (is_not_finite(node.text)) {
    const std::string range = plugins::range_text(info);
    problems_.add(node.position, path,
                  "'" + node.text + "' is not a finite number" +
                      (range.empty() ? "" : "; allowed: " + range));
    return {};
  }
  const ParsedNumber parsed = parse_number(node.text);
  if (!parsed.is_number) {
    wrong(node, path, "a number");
    return {};
  }
  if (parsed.overflows) {
    problems_.add(node.position, path, node.text + " is beyond what a double can hold");
    return {};
  }
  if (!plugins::in_range(info, parsed.number)) {
    out_of_range(info, node, path);
    return {};
  }
  ParameterValue result = scalar(ParameterKind::number);
  result.number = parsed.number;
  return result;
}

Validator::Read Validator::integer(const ParameterInfo& info, const Node& node,
                                   const std::string& path) {
  if (!is_plain_scalar(node, path, "an integer")) return {};
  if (!is_integer_text(node.text)) {
    // 1e3 and 2.0 are whole, but a slip such as 1e-3 should not pass by accident.
    const ParsedNumber parsed = parse_number(node.text);
    const bool whole = parsed.is_number && !parsed.overflows && std::abs(parsed.number) < 1e15 &&
                       std::trunc(parsed.number) == parsed.number;
    wrong(node, path, "an integer",
          whole ? "; write " + std::to_string(static_cast<std::int64_t>(parsed.number)) : "");
    return {};
  }
  ParameterValue result = scalar(ParameterKind::integer);
  const std::string_view text = without_plus(node.text);
  const auto error = std::from_chars(text.data(), text.data() + text.size(), result.integer).ec;
  if (error != std::errc()) {
    problems_.add(node.position, path, node.text + " is beyond 64 bits; allowed: " + most_of(info));
    return {};
  }
  if (!plugins::in_range(info, static_cast<double>(result.integer))) {
    out_of_range(info, node, path);
    return {};
  }
  return result;
}

Validator::Read Validator::boolean(const Node& node, const std::string& path) {
  if (!is_plain_scalar(node, path, "true or false")) return {};
  if (node.text != "true" && node.text != "false") {
    wrong(node, path, "true or false");
    return {};
  }
  ParameterValue result = scalar(ParameterKind::boolean);
  result.integer = node.text == "true" ? 1 : 0;
  return result;
}

std::optional<std::string> Validator::text(const Node& node, const std::string& path) {
  if (node.kind != Node::Kind::scalar) {
    wrong(node, path, "a text");
    return {};
  }
  if (!node.quoted && looks_typed(node.text)) {
    wrong(node, path, "a text", "; put it in quotes");
    return {};
  }
  // Plugins see NUL-terminated texts.
  if (node.text.find('\0') != std::string::npos) {
    problems_.add(node.position, path, "a text must not contain the NUL character");
    return {};
  }
  return node.text;
}

Validator::Read Validator::choice(const ParameterInfo& info, const Node& node,
                                  const std::string& path) {
  const std::vector<std::string> choices = plugins::choices_of(info);
  if (node.kind != Node::Kind::scalar) {
    wrong(node, path, "one of " + plugins::join(choices));
    return {};
  }
  if (std::find(choices.begin(), choices.end(), node.text) == choices.end()) {
    problems_.add(node.position, path,
                  node.description() + " is not among the choices; allowed: " +
                      plugins::join(choices) + plugins::did_you_mean(node.text, choices));
    return {};
  }
  ParameterValue result = scalar(ParameterKind::choice);
  result.text = node.text;
  return result;
}

Validator::Read Validator::list(const ParameterInfo& info, const Node& node,
                                const std::string& path, const ParameterValue* base) {
  if (node.patch) return patched_list(info, node, path, base);
  if (node.kind != Node::Kind::sequence) {
    wrong(node, path, "a list", "; write [a, b] or a line '- a' for each element");
    return {};
  }
  const std::size_t count = node.items.size();
  if (count < info.minimum_count || count > info.maximum_count) {
    problems_.add(node.position, path,
                  plugins::plural(count, "element") + "; allowed: " + plugins::count_text(info));
    return {};
  }
  ParameterValue result = scalar(ParameterKind::list);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    Read element = value(info.fields[0], node.items[i], indexed(path, i), nullptr);
    if (!element) continue;
    element->key.clear();
    result.items.push_back(std::move(*element));
  }
  return result;
}

Validator::Read Validator::patched_list(const ParameterInfo& info, const Node& node,
                                        const std::string& path, const ParameterValue* base) {
  ParameterValue result = base != nullptr ? *base : plugins::default_of(info);
  for (const Node& item : node.items) {
    std::size_t index = result.items.size();
    std::from_chars(item.key.data(), item.key.data() + item.key.size(), index);
    if (index >= result.items.size()) {
      problems_.add(item.position, joined(path, item.key),
                    "no such element; the list has " + std::to_string(result.items.size()));
      continue;
    }
    const ParameterValue old = result.items[index];
    Read element = value(info.fields[0], item, indexed(path, index), &old);
    if (element) result.items[index] = std::move(*element);
  }
  return result;
}

Validator::Read Validator::table(const ParameterInfo& info, const Node& node,
                                 const std::string& path) {
  if (!expect_mapping(node, path)) return {};
  ParameterValue result = scalar(ParameterKind::table);
  for (const Node& item : node.items) {
    Read entry = number(info, item, joined(path, item.key));
    if (!entry) continue;
    entry->key = item.key;
    result.items.push_back(std::move(*entry));
  }
  return result;
}

}  // namespace somas::experiment
