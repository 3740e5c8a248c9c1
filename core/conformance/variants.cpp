#include "core/conformance/variants.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/experiment/overlay.hpp"
#include "core/experiment/validate.hpp"
#include "core/plugins/relations.hpp"
#include "core/plugins/suggest.hpp"
#include "core/plugins/yaml_text.hpp"

namespace somas::conformance {
namespace {

using plugins::ParameterValue;

/// The values that a parameter is tried at.
std::vector<ParameterValue> ends_of(const ParameterInfo& info, const ParameterValue& now) {
  std::vector<ParameterValue> ends;
  const auto add = [&](auto change) {
    ParameterValue end = now;
    end.kind = info.kind;
    end.key = info.name;
    change(end);
    if (!(end == now)) ends.push_back(std::move(end));
  };
  const bool below = std::isfinite(info.minimum), above = std::isfinite(info.maximum);
  switch (info.kind) {
    case ParameterKind::number: {
      const double width = below && above ? info.maximum - info.minimum : 1;
      const double least = info.minimum_open != 0 ? info.minimum + 1e-3 * width : info.minimum;
      if (below) add([&](ParameterValue& v) { v.number = least; });
      if (above) add([&](ParameterValue& v) { v.number = info.maximum; });
      break;
    }
    case ParameterKind::integer: {
      const auto whole = [](double limit) { return static_cast<std::int64_t>(limit); };
      const std::int64_t step = info.minimum_open != 0 ? 1 : 0;
      constexpr double exact = 9e15;
      if (below && std::abs(info.minimum) < exact)
        add([&](ParameterValue& v) { v.integer = whole(std::ceil(info.minimum)) + step; });
      if (above && std::abs(info.maximum) < exact)
        add([&](ParameterValue& v) { v.integer = whole(std::floor(info.maximum)); });
      break;
    }
    case ParameterKind::boolean:
      for (const std::int64_t truth : {0, 1}) add([&](ParameterValue& v) { v.integer = truth; });
      break;
    case ParameterKind::choice:
      for (const std::string& word : plugins::choices_of(info))
        add([&](ParameterValue& v) { v.text = word; });
      break;
    case ParameterKind::list:
      if (now.items.size() > info.minimum_count)
        add([&](ParameterValue& v) { v.items.resize(info.minimum_count); });
      break;
    default:
      break;
  }
  return ends;
}

std::string text_of(const std::string& path, const ParameterValue& value) {
  if (plugins::is_inline(value)) return path + " = " + plugins::yaml_inline(value);
  return path + " with " + plugins::plural(value.items.size(), "element");
}

bool breaks_relations(std::span<const ParameterInfo> fields, const ParameterValue& group) {
  bool broken = false;
  plugins::find_broken(fields, group, [&](const plugins::BrokenRelation&) { broken = true; });
  return broken;
}

/// Hands on every variant of a group; the caller puts it where it belongs.
using Found = std::function<void(const std::string& text, ParameterValue group)>;

void vary(std::span<const ParameterInfo> fields, const ParameterValue& group,
          const std::string& prefix, const Found& found) {
  const auto with = [&](const ParameterValue& field) {
    ParameterValue changed = group;
    const auto place = std::find_if(changed.items.begin(), changed.items.end(),
                                    [&](const ParameterValue& v) { return v.key == field.key; });
    if (place == changed.items.end())
      changed.items.push_back(field);
    else
      *place = field;
    return changed;
  };
  for (const ParameterInfo& info : fields) {
    const std::string path = prefix + info.name;
    const ParameterValue* known = group.find(info.name);
    const ParameterValue now = known != nullptr ? *known : ParameterValue{};
    for (const ParameterValue& end : ends_of(info, now)) {
      ParameterValue changed = with(end);
      if (!breaks_relations(fields, changed)) found(text_of(path, end), std::move(changed));
    }
    if (info.kind == ParameterKind::group && known != nullptr)
      vary(plugins::fields_of(info), now, path + ".",
           [&](const std::string& text, ParameterValue inner) { found(text, with(inner)); });
    // One element stands for all of a list.
    const bool groups = info.kind == ParameterKind::list && info.field_count == 1 &&
                        info.fields[0].kind == ParameterKind::group;
    if (groups && !now.items.empty())
      vary(plugins::fields_of(info.fields[0]), now.items[0], path + "[0].",
           [&](const std::string& text, ParameterValue element) {
             ParameterValue list = now;
             list.items[0] = std::move(element);
             found(text, with(list));
           });
  }
}

void collect_undocumented(std::span<const ParameterInfo> fields, const std::string& prefix,
                          std::vector<std::string>& names) {
  for (const ParameterInfo& info : fields) {
    if (std::string_view(info.doc).empty()) names.push_back(prefix + info.name);
    if (info.kind == ParameterKind::group)
      collect_undocumented(plugins::fields_of(info), prefix + info.name + ".", names);
    if (info.kind == ParameterKind::list && info.field_count == 1 &&
        info.fields[0].kind == ParameterKind::group)
      collect_undocumented(plugins::fields_of(info.fields[0]), prefix + info.name + "[].", names);
  }
}

}  // namespace

ParameterValue given_parameters(const plugins::Library& library, const ClassInfo& info,
                                const std::vector<std::string>& assignments) {
  experiment::Node root;
  root.kind = experiment::Node::Kind::mapping;
  std::vector<std::string> ids;
  for (const ClassInfo& one : library.classes()) {
    ids.emplace_back(one.id);
    experiment::Node& block = root.items.emplace_back();
    block.kind = experiment::Node::Kind::mapping;
    block.key = one.id;
    block.position = block.key_position = {"--set", 0, 0};
  }
  for (const std::string& assignment : assignments)
    experiment::apply_override(root, experiment::set_by_hand(assignment));

  experiment::Problems problems;
  for (const experiment::Node& block : root.items)
    if (std::find(ids.begin(), ids.end(), block.key) == ids.end())
      problems.add(block.key_position, block.key,
                   "no class of this file; allowed: " + plugins::join(ids) +
                       plugins::did_you_mean(block.key, ids));
  problems.raise();
  experiment::Validator validator(problems);
  const experiment::Node& block = *root.find(info.id);
  ParameterValue values;
  if (validator.expect_mapping(block, info.id))
    values = validator.group({info.parameters, info.parameter_count}, block, info.id);
  problems.raise();
  return values;
}

std::vector<Variant> variants_of(std::span<const ParameterInfo> fields,
                                 const ParameterValue& values) {
  std::vector<Variant> variants;
  vary(fields, values, "", [&](const std::string& text, ParameterValue group) {
    variants.push_back({text, std::move(group)});
  });
  return variants;
}

std::vector<std::string> undocumented_in(std::span<const ParameterInfo> fields) {
  std::vector<std::string> names;
  collect_undocumented(fields, "", names);
  return names;
}

}  // namespace somas::conformance
