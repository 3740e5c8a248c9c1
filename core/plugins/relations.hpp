// How parameters of one group bear on each other: told to people, and tested on values.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/plugins/values.hpp"

namespace somas::plugins {

/// The relations that begin with a parameter.
[[nodiscard]] inline std::span<const Relation> relations_of(const ParameterInfo& info) {
  return {info.relations, info.relation_count};
}

/// The words of only_when and required_when.
[[nodiscard]] inline std::vector<std::string> words_of(const Relation& relation) {
  return {relation.words, relation.words + relation.word_count};
}

/// "box or enclosure".
[[nodiscard]] std::string words_text(const Relation& relation);
/// What a relation asks of the parameter that it begins with: "at most beta_max", "only when region
/// is square".
[[nodiscard]] std::string relation_text(const Relation& relation);

/// Whether a parameter is set, see RelationKind; null or kind none: it is not.
[[nodiscard]] bool is_set(const ParameterValue* value);

/// Whether the parameter has a value that can be left out of a file's reckoning: an optional one, a
/// boolean, a text, a list or a table. Only of such a one can be said that it needs another.
[[nodiscard]] bool can_be_unset(const ParameterInfo& info);

/// A relation between two parameters of `fields` that values break.
struct BrokenRelation {
  const ParameterInfo* first = nullptr;
  const ParameterInfo* other = nullptr;
  const Relation* relation = nullptr;
};

/// Calls `found` for every relation of `fields` that `group` breaks; groups within are not looked
/// into. A relation with a parameter that is not there is skipped.
void find_broken(std::span<const ParameterInfo> fields, const ParameterValue& group,
                 const std::function<void(const BrokenRelation&)>& found);

}  // namespace somas::plugins
