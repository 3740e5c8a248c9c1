#include "plugins/specialization/tree/tree.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace somas::specialization {

namespace {

using States = std::vector<Tree::State>;
constexpr std::size_t max_states = 64;
constexpr std::size_t none = static_cast<std::size_t>(-1);

std::string path(std::size_t i, const std::string& key) {
  return "states[" + std::to_string(i) + "]." + key;
}

std::string pair_path(std::size_t pair, const char* key) {
  return "adhesion_pairs[" + std::to_string(pair) + "]." + key;
}

std::string quoted(std::string_view name) { return "'" + std::string(name) + "'"; }

/// Shortest decimal that reads back as x.
std::string text(double x) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
  return {digits.data(), end};
}

/// The names of a list of states or skills, "a, b, c".
template <class List>
std::string names(const List& list) {
  std::string joined;
  for (const auto& item : list) joined += (joined.empty() ? "" : ", ") + std::string(item.name);
  return joined;
}

/// Position of a name in a list of states or skills, or `none`.
template <class List>
std::size_t find(const List& list, std::string_view name) {
  const auto is_it = [&](const auto& item) { return item.name == name; };
  const auto it = std::find_if(list.begin(), list.end(), is_it);
  return it == list.end() ? none : static_cast<std::size_t>(it - list.begin());
}

std::size_t parent_of(const States& states, std::size_t i) {
  return states[i].parent.empty() ? none : find(states, states[i].parent);
}

void check_names(const States& states) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i].name.empty()) throw ParameterError(path(i, "name"), "a state needs a name");
    if (const std::size_t first = find(states, states[i].name); first < i)
      throw ParameterError(path(i, "name"), "states[" + std::to_string(first) + "] has the name " +
                                                quoted(states[i].name) + " already");
  }
}

void check_parents(const States& states) {
  std::size_t root = none;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!states[i].parent.empty()) {
      if (parent_of(states, i) == none)
        throw ParameterError(path(i, "parent"), "no state is called " + quoted(states[i].parent) +
                                                    "; the states are " + names(states));
      continue;
    }
    if (root != none)
      throw ParameterError(path(i, "parent"),
                           quoted(states[i].name) + " needs a parent: the root is " +
                               quoted(states[root].name) + " already, and there is one only");
    root = i;
  }
  if (root == none)
    throw ParameterError("states", "no state is the root: exactly one must have no parent");
}

/// Reports the loop above `start`, a state that the root does not reach.
[[noreturn]] void throw_loop(const States& states, std::size_t start) {
  // As many steps up as there are states end inside the loop; report it from its first state.
  std::size_t on_loop = start;
  for (std::size_t n = 0; n < states.size(); ++n) on_loop = parent_of(states, on_loop);
  std::size_t first = on_loop;
  for (std::size_t i = parent_of(states, on_loop); i != on_loop; i = parent_of(states, i))
    first = std::min(first, i);
  std::string loop = states[first].name;
  std::size_t i = first;
  do {
    i = parent_of(states, i);
    loop += " -> " + states[i].name;
  } while (i != first);
  throw ParameterError(path(first, "parent"), "the parents run in a loop: " + loop);
}

/// Parents first; otherwise the order of the list.
std::vector<std::size_t> order_of(const States& states) {
  std::vector<std::size_t> order;
  std::vector<bool> placed(states.size());
  const auto ready = [&](std::size_t i) {
    const std::size_t parent = parent_of(states, i);
    return !placed[i] && (parent == none || placed[parent]);
  };
  while (order.size() < states.size()) {
    std::size_t next = 0;
    while (next < states.size() && !ready(next)) ++next;
    if (next == states.size())
      throw_loop(states, static_cast<std::size_t>(std::find(placed.begin(), placed.end(), false) -
                                                  placed.begin()));
    placed[next] = true;
    order.push_back(next);
  }
  return order;
}

/// Position of the state that a pair names by one of its keys.
std::size_t member_of(const States& states, std::size_t pair, const char* key,
                      const std::string& name) {
  const std::size_t i = find(states, name);
  if (i == none)
    throw ParameterError(pair_path(pair, key), "no state is called " + quoted(name) +
                                                   "; the states are " + names(states));
  return i;
}

/// The strengths that the pairs give, by state and state; NaN elsewhere.
std::vector<std::vector<double>> adhesion_of(const States& states,
                                             const std::vector<Tree::AdhesionPair>& pairs) {
  const std::size_t count = states.size();
  constexpr double unset = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::vector<double>> adhesion(count, std::vector<double>(count, unset));
  std::vector<std::vector<std::size_t>> named_by(count, std::vector<std::size_t>(count, none));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const std::size_t a = member_of(states, p, "first", pairs[p].first);
    const std::size_t b = member_of(states, p, "second", pairs[p].second);
    if (a == b)
      throw ParameterError(pair_path(p, "second"),
                           quoted(states[a].name) + " is both of the pair; among its own cells a " +
                               "state has its `adhesion`");
    if (named_by[a][b] != none)
      throw ParameterError(pair_path(p, "second"),
                           "adhesion_pairs[" + std::to_string(named_by[a][b]) + "] is about " +
                               quoted(states[a].name) + " and " + quoted(states[b].name) +
                               " already");
    named_by[a][b] = named_by[b][a] = p;
    adhesion[a][b] = adhesion[b][a] = pairs[p].strength;
  }
  return adhesion;
}

std::string range(const SkillSpec& spec) {
  if (spec.maximum == std::numeric_limits<double>::infinity())
    return "at least " + text(spec.minimum);
  return "from " + text(spec.minimum) + " to " + text(spec.maximum);
}

}  // namespace

Tree::Tree(const Parameters& parameters) : states_(parameters.states), budget_(parameters.budget) {
  if (states_.empty()) throw ParameterError("states", "a tree needs at least one state");
  if (states_.size() > max_states)
    throw ParameterError("states", std::to_string(states_.size()) + " states; at most " +
                                       std::to_string(max_states) + " are possible");
  check_names(states_);
  check_parents(states_);
  order_ = order_of(states_);
  adhesion_ = adhesion_of(states_, parameters.adhesion_pairs);
}

void Tree::grow(GenesView, std::span<const SkillInfo> skills, TreeSink& tree) const {
  std::vector<std::size_t> emitted_as(states_.size(), none);
  for (std::size_t n = 0; n < order_.size(); ++n) {
    const std::size_t i = order_[n];
    const State& state = states_[i];
    const std::size_t parent = parent_of(states_, i);
    const std::vector<double> values = points(i, skills);
    check_budget(i, skills, values);
    check_signal(i, tree.morphogens());
    std::vector<double> adhesion_with;
    for (std::size_t k = 0; k < n; ++k) adhesion_with.push_back(adhesion_[i][order_[k]]);
    emitted_as[i] = n;
    tree.add({.name = state.name,
              .key = stable_key(state.name),
              .parent = parent == none ? no_state : static_cast<std::uint16_t>(emitted_as[parent]),
              .mass = state.mass,
              .radius = state.radius,
              .stiffness = state.stiffness,
              .adhesion = state.adhesion,
              .adhesion_range = state.adhesion_range,
              .skills = values,
              .motility = state.motility,
              .motility_signal = static_cast<std::uint32_t>(state.motility_signal),
              .adhesion_with = adhesion_with,
              .quiescence_threshold = state.quiescence_threshold,
              .division_threshold = state.division_threshold,
              .specialization_threshold = state.specialization_threshold,
              .apoptosis_threshold = state.apoptosis_threshold});
  }
}

void Tree::check_signal(std::size_t state, std::uint32_t morphogens) const {
  const std::int64_t signal = states_[state].motility_signal;
  // Without motility the default is never looked up, even where there are no morphogens.
  if (signal < morphogens || (signal == 0 && states_[state].motility == 0)) return;
  const std::string allowed = morphogens == 0 ? "has no morphogens"
                              : morphogens == 1
                                  ? "has morphogen 0 only"
                                  : "has morphogens 0 to " + std::to_string(morphogens - 1);
  throw ParameterError(
      path(state, "motility_signal"),
      "there is no morphogen " + std::to_string(signal) + ": the world " + allowed);
}

/// A value per skill: the state's own, or the fallback.
std::vector<double> Tree::points(std::size_t state, std::span<const SkillInfo> skills) const {
  std::vector<double> values;
  for (const SkillInfo& skill : skills) values.push_back(skill.spec.fallback);
  for (const auto& [name, value] : states_[state].skills) {
    const std::size_t k = find(skills, name);
    const std::string where = path(state, "skills." + name);
    if (k == none)
      throw ParameterError(where,
                           "no skill is called " + quoted(name) +
                               "; skills come from the model and the environments in use, here " +
                               names(skills));
    const SkillSpec& spec = skills[k].spec;
    if (!(value >= spec.minimum && value <= spec.maximum))
      throw ParameterError(where,
                           quoted(name) + " is " + text(value) + " but must be " + range(spec));
    values[k] = value;
  }
  return values;
}

void Tree::check_budget(std::size_t state, std::span<const SkillInfo> skills,
                        std::span<const double> points) const {
  if (!budget_) return;
  double sum = 0;
  for (std::size_t k = 0; k < skills.size(); ++k) sum += points[k] * skills[k].spec.cost;
  // Decimals like 0.1 are not exact: a hair above is within.
  if (sum > *budget_ * (1 + 1e-9))
    throw ParameterError(path(state, "skills"), quoted(states_[state].name) + " spends " +
                                                    text(sum) + " points; the budget is " +
                                                    text(*budget_));
}

}  // namespace somas::specialization
