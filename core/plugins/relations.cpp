#include "core/plugins/relations.hpp"

#include <algorithm>

namespace somas::plugins {
namespace {

double number_of(const ParameterValue& value) {
  return value.kind == ParameterKind::integer ? static_cast<double>(value.integer) : value.number;
}

bool is_number(const ParameterValue& value) {
  return value.kind == ParameterKind::number || value.kind == ParameterKind::integer;
}

// Two integers are compared as they are: doubles would merge those beyond 2^53.
bool less(const ParameterValue& a, const ParameterValue& b) {
  if (a.kind == ParameterKind::integer && b.kind == ParameterKind::integer)
    return a.integer < b.integer;
  return number_of(a) < number_of(b);
}

bool equal(const ParameterValue& a, const ParameterValue& b) {
  if (is_number(a) && is_number(b)) return !less(a, b) && !less(b, a);
  return a.kind == b.kind && a.text == b.text;
}

bool has_word(const ParameterValue* value, const Relation& relation) {
  if (value == nullptr) return false;
  const bool is_boolean = value->kind == ParameterKind::boolean;
  const std::string word = !is_boolean ? value->text : value->integer != 0 ? "true" : "false";
  const std::vector<std::string> words = words_of(relation);
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool holds(const Relation& relation, const ParameterValue* first, const ParameterValue* other) {
  const bool both = first != nullptr && other != nullptr;
  switch (relation.kind) {
    case RelationKind::at_most:
      return !both || !less(*other, *first);
    case RelationKind::less_than:
      return !both || less(*first, *other);
    case RelationKind::differs:
      return !both || !equal(*first, *other);
    case RelationKind::needs:
      return !is_set(first) || is_set(other);
    case RelationKind::excludes:
      return !is_set(first) || !is_set(other);
    case RelationKind::only_when:
      return !is_set(first) || has_word(other, relation);
    case RelationKind::required_when:
      return !has_word(other, relation) || is_set(first);
  }
  return true;
}

}  // namespace

std::string words_text(const Relation& relation) {
  const std::vector<std::string> words = words_of(relation);
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

std::string relation_text(const Relation& relation) {
  const std::string other = relation.other, words = words_text(relation);
  switch (relation.kind) {
    case RelationKind::at_most:
      return "at most " + other;
    case RelationKind::less_than:
      return "less than " + other;
    case RelationKind::differs:
      return "not the same as " + other;
    case RelationKind::needs:
      return "needs " + other;
    case RelationKind::excludes:
      return "not together with " + other;
    case RelationKind::only_when:
      return "only when " + other + " is " + words;
    case RelationKind::required_when:
      return "required when " + other + " is " + words;
  }
  return "";
}

bool is_set(const ParameterValue* value) {
  if (value == nullptr) return false;
  switch (value->kind) {
    case ParameterKind::none:
      return false;
    case ParameterKind::boolean:
      return value->integer != 0;
    case ParameterKind::text:
      return !value->text.empty();
    case ParameterKind::list:
    case ParameterKind::table:
      return !value->items.empty();
    default:
      return true;
  }
}

bool can_be_unset(const ParameterInfo& info) {
  const ParameterKind kind = info.kind;
  const bool may_be_empty = kind == ParameterKind::boolean || kind == ParameterKind::text ||
                            kind == ParameterKind::list || kind == ParameterKind::table;
  const bool optional = info.required == 0 && info.fallback.kind == ParameterKind::none;
  return may_be_empty || optional;
}

void find_broken(std::span<const ParameterInfo> fields, const ParameterValue& group,
                 const std::function<void(const BrokenRelation&)>& found) {
  for (const ParameterInfo& first : fields)
    for (const Relation& relation : relations_of(first)) {
      const auto other = std::find_if(fields.begin(), fields.end(), [&](const ParameterInfo& info) {
        return std::string_view(info.name) == relation.other;
      });
      if (other == fields.end()) continue;
      if (!holds(relation, group.find(first.name), group.find(relation.other)))
        found({&first, &*other, &relation});
    }
}

}  // namespace somas::plugins
