#include "plugins/specialization/evolved_tree/variation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "somas/sdk/parameters.hpp"

namespace somas::specialization {

namespace {

// A hair above the budget is within: sums of decimals are not exact.
constexpr double hair = 1e-9;
// The largest share of the budget that moves in a step, and when a state is made.
constexpr double small_move = 0.25, large_move = 1;

/// A key that no state of the tree has.
std::uint64_t new_key(const TreeGenes& tree, Rng& rng) {
  std::uint64_t key = rng.bits();
  while (key == 0 || tree.find(key)) key = rng.bits();
  return key;
}

std::size_t any_of(const std::vector<std::size_t>& items, Rng& rng) {
  return items[static_cast<std::size_t>(rng.below(items.size()))];
}

}  // namespace

void TreeVariation::declare(std::span<const SkillInfo> skills) {
  skills_.clear();
  double least = 0;
  for (const SkillInfo& skill : skills) {
    if (!(skill.spec.cost > 0)) continue;
    skills_.push_back({std::string(skill.name), stable_key(skill.name), skill.spec});
    least += skill.spec.minimum * skill.spec.cost;
  }
  std::ranges::sort(skills_, {}, &EvolvingSkill::key);
  if (least > p_.budget)
    throw ParameterError("budget", "the least points of all skills cost " + std::to_string(least) +
                                       ", more than the budget");
}

// ---- points ------------------------------------------------------------------------------------

double TreeVariation::spent(const std::vector<double>& points) const {
  double sum = 0;
  for (std::size_t k = 0; k < skills_.size(); ++k) sum += points[k] * skills_[k].spec.cost;
  return sum;
}

void TreeVariation::settle(std::vector<double>& points) const {
  double least = 0;
  for (std::size_t k = 0; k < skills_.size(); ++k) {
    const SkillSpec& spec = skills_[k].spec;
    points[k] = std::clamp(points[k], spec.minimum, spec.maximum);
    least += spec.minimum * spec.cost;
  }
  const double total = spent(points);
  if (total <= p_.budget) return;
  const double keep = (p_.budget - least) / (total - least);
  for (std::size_t k = 0; k < skills_.size(); ++k) {
    const double minimum = skills_[k].spec.minimum;
    points[k] = minimum + (points[k] - minimum) * keep;
  }
}

void TreeVariation::move(std::vector<double>& points, double most, Rng& rng) const {
  if (skills_.size() < 2) return;
  const auto from = static_cast<std::size_t>(rng.below(skills_.size()));
  auto to = static_cast<std::size_t>(rng.below(skills_.size() - 1));
  if (to >= from) ++to;
  const SkillSpec &giver = skills_[from].spec, &taker = skills_[to].spec;
  const double there = (points[from] - giver.minimum) * giver.cost;
  const double room = (taker.maximum - points[to]) * taker.cost;
  const double amount = std::min({most * p_.budget * rng.uniform(), there, room});
  points[from] -= amount / giver.cost;
  points[to] += amount / taker.cost;
  settle(points);
}

// ---- heredity ----------------------------------------------------------------------------------

void TreeVariation::random(const Layout&, Rng& rng, Genes& genes) const {
  TreeGenes tree;
  for (const EvolvingSkill& skill : skills_) tree.skills.push_back(skill.key);
  std::vector<double> points;
  for (const EvolvingSkill& skill : skills_)
    points.push_back(p_.budget / (static_cast<double>(skills_.size()) * skill.spec.cost));
  settle(points);
  // A little apart, so that no two founders are the same.
  move(points, 0.01, rng);
  tree.add(stable_key("root"), no_parent, std::move(points));
  encode(tree, genes);
}

void TreeVariation::conform(const Layout&, Rng&, Genes& genes) const {
  const TreeGenes known = decode(genes);
  TreeGenes tree;
  for (const EvolvingSkill& skill : skills_) tree.skills.push_back(skill.key);
  if (known.skills == tree.skills && fits(known)) return;
  for (const TreeState& state : known.states) {
    std::vector<double> points;
    for (const EvolvingSkill& skill : skills_) {
      const auto at = std::ranges::find(known.skills, skill.key);
      points.push_back(at == known.skills.end()
                           ? skill.spec.minimum
                           : state.points[static_cast<std::size_t>(at - known.skills.begin())]);
    }
    settle(points);
    tree.add(state.key, state.parent, std::move(points));
  }
  while (!fits(tree)) {
    std::size_t last = tree.states.size() - 1;
    while (tree.states.size() <= static_cast<std::size_t>(p_.max_states) &&
           tree.depth(last) <= static_cast<std::size_t>(p_.max_depth))
      --last;
    tree.remove(last);
  }
  tree.sort();
  encode(tree, genes);
}

bool TreeVariation::fits(const TreeGenes& tree) const {
  return tree.states.size() <= static_cast<std::size_t>(p_.max_states) &&
         tree.depth() <= static_cast<std::size_t>(p_.max_depth);
}

/// States that may have another child.
std::vector<std::size_t> TreeVariation::open_parents(const TreeGenes& tree) const {
  std::vector<std::size_t> open;
  if (tree.states.size() >= static_cast<std::size_t>(p_.max_states)) return open;
  for (std::size_t s = 0; s < tree.states.size(); ++s)
    if (tree.depth(s) < static_cast<std::size_t>(p_.max_depth)) open.push_back(s);
  return open;
}

/// States with children between which and them there is room for another.
std::vector<std::size_t> TreeVariation::divisible(const TreeGenes& tree) const {
  std::vector<std::size_t> found;
  if (tree.states.size() >= static_cast<std::size_t>(p_.max_states)) return found;
  for (std::size_t s = 0; s < tree.states.size(); ++s) {
    std::size_t deepest = 0;
    for (std::size_t below = 0; below < tree.states.size(); ++below)
      for (std::size_t up = tree.states[below].parent; up != no_parent; up = tree.states[up].parent)
        if (up == s) deepest = std::max(deepest, tree.depth(below));
    if (deepest > 0 && deepest < static_cast<std::size_t>(p_.max_depth)) found.push_back(s);
  }
  return found;
}

void TreeVariation::mutate(const Layout&, Rng& rng, Genes& genes) const {
  TreeGenes tree = decode(genes);
  const double add_weight = open_parents(tree).empty() ? 0 : p_.add_weight;
  const double split_weight = divisible(tree).empty() ? 0 : p_.split_weight;
  const double remove_weight = tree.states.size() < 2 ? 0 : p_.remove_weight;
  double draw = rng.uniform() * (p_.move_weight + add_weight + split_weight + remove_weight);
  if ((draw -= add_weight) < 0)
    add(tree, rng);
  else if ((draw -= split_weight) < 0)
    split(tree, rng);
  else if ((draw -= remove_weight) < 0)
    remove(tree, rng);
  else
    shift(tree, rng);
  tree.sort();
  encode(tree, genes);
}

void TreeVariation::shift(TreeGenes& tree, Rng& rng) const {
  const auto s = static_cast<std::size_t>(rng.below(tree.states.size()));
  move(tree.states[s].points, small_move, rng);
}

void TreeVariation::add(TreeGenes& tree, Rng& rng) const {
  const std::size_t parent = any_of(open_parents(tree), rng);
  std::vector<double> points = tree.states[parent].points;
  move(points, large_move, rng);
  tree.add(new_key(tree, rng), parent, std::move(points));
}

void TreeVariation::split(TreeGenes& tree, Rng& rng) const {
  const std::size_t above = any_of(divisible(tree), rng);
  std::vector<double> points = tree.states[above].points;
  move(points, large_move, rng);
  const std::size_t between = tree.add(new_key(tree, rng), above, std::move(points));
  for (std::size_t s = 0; s < between; ++s)
    if (tree.states[s].parent == above) tree.states[s].parent = between;
}

void TreeVariation::remove(TreeGenes& tree, Rng& rng) const {
  tree.remove(1 + static_cast<std::size_t>(rng.below(tree.states.size() - 1)));
}

void TreeVariation::cross(const Layout&, GenesView first, GenesView second, Rng& rng,
                          Genes& child) const {
  TreeGenes tree = decode(first);
  const TreeGenes other = decode(second);
  if (tree.skills != other.skills)
    throw std::runtime_error("two trees of different skills cannot be crossed");
  for (TreeState& state : tree.states) {
    const auto twin = other.find(state.key);
    if (twin && rng.chance(0.5)) state.points = other.states[*twin].points;
  }
  graft(tree, other, rng);
  tree.sort();
  encode(tree, child);
}

void TreeVariation::graft(TreeGenes& tree, const TreeGenes& donor, Rng& rng) const {
  for (const TreeState& state : donor.states) {
    if (state.parent == no_parent || tree.find(state.key)) continue;
    const auto parent = tree.find(donor.states[state.parent].key);
    if (!parent || !rng.chance(0.5)) continue;
    tree.add(state.key, *parent, state.points);
    if (!fits(tree)) tree.remove(tree.states.size() - 1);
  }
}

double TreeVariation::distance(GenesView first, GenesView second) const {
  const TreeGenes a = decode(first), b = decode(second);
  if (a.skills != b.skills) return 1;
  double sum = 0;
  std::size_t shared = 0;
  for (const TreeState& state : a.states) {
    const auto twin = b.find(state.key);
    if (!twin) continue;
    ++shared;
    double apart = 0;
    for (std::size_t k = 0; k < state.points.size(); ++k)
      apart += std::abs(state.points[k] - b.states[*twin].points[k]) *
               (k < skills_.size() ? skills_[k].spec.cost : 1);
    sum += std::min(1.0, 0.5 * apart / p_.budget);
  }
  const std::size_t all = a.states.size() + b.states.size() - shared;
  return (sum + static_cast<double>(all - shared)) / static_cast<double>(all);
}

// ---- JSON and checks ---------------------------------------------------------------------------

void TreeVariation::to_json(GenesView genes, JsonWriter& out) const {
  const TreeGenes tree = decode(genes);
  out.open_list("skills");
  for (const std::uint64_t key : tree.skills) {
    const auto known = std::ranges::find(skills_, key, &EvolvingSkill::key);
    out.open_object("");
    out.key64("key", key);
    out.text("name", known == skills_.end() ? "" : known->name);
    out.close();
  }
  out.close();
  out.open_list("states");
  for (const TreeState& state : tree.states) {
    out.open_object("");
    out.key64("key", state.key);
    out.integer("parent", state.parent == no_parent ? -1 : static_cast<std::int64_t>(state.parent));
    out.open_list("points");
    for (const double points : state.points) out.number("", points);
    out.close();
    out.close();
  }
  out.close();
}

void TreeVariation::from_json(const JsonReader& in, Genes& genes) const {
  TreeGenes tree;
  const JsonReader& skills = in.member("skills");
  for (std::size_t k = 0; k < skills.size(); ++k)
    tree.skills.push_back(skills.item(k).member("key").key64());
  const JsonReader& states = in.member("states");
  for (std::size_t s = 0; s < states.size(); ++s) {
    const JsonReader& from = states.item(s);
    const std::int64_t parent = from.member("parent").integer();
    const JsonReader& points = from.member("points");
    if (points.size() != tree.skills.size() || parent < -1 || parent >= std::int64_t(s))
      throw std::runtime_error("state " + std::to_string(s) +
                               " needs an earlier parent and points in every skill");
    std::vector<double> values;
    for (std::size_t k = 0; k < points.size(); ++k) values.push_back(points.item(k).number());
    tree.add(from.member("key").key64(), parent < 0 ? no_parent : static_cast<std::size_t>(parent),
             std::move(values));
  }
  encode(tree, genes);
  static_cast<void>(decode(genes));
}

void TreeVariation::check(const Layout&, GenesView genes) const {
  static_cast<void>(fitting(genes));
}

TreeGenes TreeVariation::fitting(GenesView genes) const {
  TreeGenes tree = decode(genes);
  const bool same = std::ranges::equal(tree.skills, skills_, {}, {}, &EvolvingSkill::key);
  if (!same) throw std::runtime_error("the genes of the tree are for other skills");
  if (!fits(tree))
    throw std::runtime_error("the genes hold " + std::to_string(tree.states.size()) + " states, " +
                             std::to_string(tree.depth()) + " deep; at most " +
                             std::to_string(p_.max_states) + " and " +
                             std::to_string(p_.max_depth) + " are set");
  for (const TreeState& state : tree.states) {
    for (std::size_t k = 0; k < skills_.size(); ++k)
      if (!(state.points[k] >= skills_[k].spec.minimum &&
            state.points[k] <= skills_[k].spec.maximum))
        throw std::runtime_error("the points of skill '" + skills_[k].name +
                                 "' are outside its range");
    if (spent(state.points) > p_.budget * (1 + hair))
      throw std::runtime_error("a state spends " + std::to_string(spent(state.points)) +
                               " points of a budget of " + std::to_string(p_.budget));
  }
  return tree;
}

}  // namespace somas::specialization
