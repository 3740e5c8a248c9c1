#include "plugins/specialization/evolved_tree/variation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "somas/sdk/math.hpp"
#include "somas/sdk/parameters.hpp"

namespace somas::specialization {

namespace {

// A hair above the budget is within: sums of decimals are not exact.
constexpr double hair = 1e-9;
// The largest share of the budget that moves in a step, and when a state is made.
constexpr double small_move = 0.25, large_move = 1;
// How often an attribute that is drawn anew goes back to where evolution began.
constexpr double set_back = 0.25;

/// A key that no state of the tree has.
std::uint64_t new_key(const TreeGenes& tree, Rng& rng) {
  std::uint64_t key = rng.bits();
  while (key == 0 || tree.find(key)) key = rng.bits();
  return key;
}

/// A difference as a part of a range, at most 1.
double relative(double difference, double range) {
  if (difference == 0) return 0;
  return range > 0 ? std::min(1.0, std::abs(difference) / range) : 1;
}

std::size_t any_of(const std::vector<std::size_t>& items, Rng& rng) {
  return items[static_cast<std::size_t>(rng.below(items.size()))];
}

/// The pairs of states of both trees, each as likely from either; of one parent alone as it says.
void cross_pairs(TreeGenes& child, const TreeGenes& first, const TreeGenes& second, Rng& rng) {
  child.pairs.clear();
  for (std::size_t b = 1; b < child.states.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const std::uint64_t one = child.states[a].key, two = child.states[b].key;
      const bool in_first = first.find(one) && first.find(two);
      const bool in_second = second.find(one) && second.find(two);
      if (!in_first && !in_second) continue;
      const bool from_second = !in_first || (in_second && rng.chance(0.5));
      child.set_adhesion(one, two, (from_second ? second : first).adhesion(one, two));
    }
}

}  // namespace

void TreeVariation::declare(std::span<const SkillInfo> skills) {
  skills_.clear();
  least_ = 0;
  for (const SkillInfo& skill : skills) {
    if (!(skill.spec.cost > 0)) continue;
    skills_.push_back({std::string(skill.name), stable_key(skill.name), skill.spec});
    least_ += skill.spec.minimum * skill.spec.cost;
  }
  std::ranges::sort(skills_, {}, &EvolvingSkill::key);
  if (least_ > p_.budget)
    throw ParameterError("budget", "the least points of all skills cost " + std::to_string(least_) +
                                       ", more than the budget");
}

// ---- points ------------------------------------------------------------------------------------

double TreeVariation::spent(const std::vector<double>& points) const {
  double sum = 0;
  for (std::size_t k = 0; k < skills_.size(); ++k) sum += points[k] * skills_[k].spec.cost;
  return sum;
}

void TreeVariation::settle(std::vector<double>& points) const {
  for (std::size_t k = 0; k < skills_.size(); ++k)
    points[k] = std::clamp(points[k], skills_[k].spec.minimum, skills_[k].spec.maximum);
  const double total = spent(points);
  if (total <= p_.budget) return;
  const double keep = (p_.budget - least_) / (total - least_);
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

double TreeVariation::bought(std::size_t skill, double points) const {
  const SkillSpec& spec = skills_[skill].spec;
  const double to_spend = p_.budget - least_, spent = (points - spec.minimum) * spec.cost;
  if (p_.returns == 1 || !(spent > 0)) return points;
  const double share = std::min(1.0, spent / to_spend);
  const double value = math::exp(p_.returns * math::log(share)) * to_spend / spec.cost;
  return std::min(spec.maximum, spec.minimum + value);
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
  std::vector<double> values;
  for (const EvolvingAttribute& attribute : attributes_) {
    tree.attributes.push_back(attribute.key);
    values.push_back(attribute.start);
  }
  tree.add({stable_key("root"), no_parent, std::move(points), std::move(values)});
  encode(tree, genes);
}

void TreeVariation::conform(const Layout&, Rng&, Genes& genes) const {
  const TreeGenes known = decode(genes);
  TreeGenes tree;
  for (const EvolvingSkill& skill : skills_) tree.skills.push_back(skill.key);
  for (const EvolvingAttribute& attribute : attributes_) tree.attributes.push_back(attribute.key);
  tree.pairs = conformed_pairs(known);
  if (known.skills == tree.skills && known.attributes == tree.attributes && fits(known) &&
      known.pairs == tree.pairs && attributes_fit(known))
    return;
  for (const TreeState& state : known.states) {
    std::vector<double> points;
    for (const EvolvingSkill& skill : skills_) {
      const auto at = std::ranges::find(known.skills, skill.key);
      points.push_back(at == known.skills.end()
                           ? skill.spec.minimum
                           : state.points[static_cast<std::size_t>(at - known.skills.begin())]);
    }
    settle(points);
    tree.add({state.key, state.parent, std::move(points), conformed_attributes(known, state)});
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

std::vector<double> TreeVariation::conformed_attributes(const TreeGenes& known,
                                                        const TreeState& state) const {
  std::vector<double> values;
  for (const EvolvingAttribute& attribute : attributes_) {
    const auto at = std::ranges::find(known.attributes, attribute.key);
    const auto place = static_cast<std::size_t>(at - known.attributes.begin());
    values.push_back(
        at == known.attributes.end()
            ? attribute.start
            : std::clamp(state.attributes[place], attribute.minimum, attribute.maximum));
  }
  return values;
}

std::vector<AdhesionGene> TreeVariation::conformed_pairs(const TreeGenes& known) const {
  if (!p_.evolve_adhesion) return {};
  std::vector<AdhesionGene> pairs = known.pairs;
  for (AdhesionGene& pair : pairs) pair.strength = std::clamp(pair.strength, 0.0, p_.max_adhesion);
  return pairs;
}

bool TreeVariation::attributes_fit(const TreeGenes& tree) const {
  return std::ranges::all_of(tree.states, [&](const TreeState& state) {
    return conformed_attributes(tree, state) == state.attributes;
  });
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
  const double attribute_weight = attributes_.empty() ? 0 : p_.attribute_weight;
  double draw = rng.uniform() * (p_.move_weight + add_weight + split_weight + remove_weight +
                                 p_.redraw_weight + attribute_weight);
  if ((draw -= attribute_weight) < 0)
    redraw_attribute(tree, rng);
  else if ((draw -= p_.redraw_weight) < 0)
    redraw(tree, rng);
  else if ((draw -= add_weight) < 0)
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

// Shares of independent exponential deviates are uniform over all ways to divide a whole.
void TreeVariation::redraw(TreeGenes& tree, Rng& rng) const {
  std::vector<double>& points =
      tree.states[static_cast<std::size_t>(rng.below(tree.states.size()))].points;
  double sum = 0;
  for (double& share : points) sum += share = -math::log(1 - rng.uniform());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double share = sum > 0 ? points[k] / sum : 0;
    const SkillSpec& spec = skills_[k].spec;
    points[k] = spec.minimum + share * (p_.budget - least_) / spec.cost;
  }
  settle(points);
}

// Every value of every state, and every pair, is as likely as any other.
void TreeVariation::redraw_attribute(TreeGenes& tree, Rng& rng) const {
  const std::size_t states = tree.states.size();
  const std::size_t values = states * attributes_.size();
  const std::size_t pairs = p_.evolve_adhesion ? states * (states - 1) / 2 : 0;
  std::size_t chosen = static_cast<std::size_t>(rng.below(values + pairs));
  const bool back = rng.chance(set_back);
  if (chosen < values) {
    const EvolvingAttribute& attribute = attributes_[chosen % attributes_.size()];
    tree.states[chosen / attributes_.size()].attributes[chosen % attributes_.size()] =
        back ? attribute.start : rng.uniform(attribute.minimum, attribute.maximum);
    return;
  }
  chosen -= values;
  std::size_t second = 1;
  for (; chosen >= second; ++second) chosen -= second;
  const auto strength =
      back ? std::nullopt : std::optional<double>(rng.uniform(0, p_.max_adhesion));
  tree.set_adhesion(tree.states[chosen].key, tree.states[second].key, strength);
}

std::size_t TreeVariation::add_copy(TreeGenes& tree, std::size_t parent, Rng& rng) const {
  TreeState copy = tree.states[parent];
  const std::uint64_t origin = copy.key;
  move(copy.points, large_move, rng);
  copy.key = new_key(tree, rng);
  copy.parent = parent;
  for (const TreeState& other : tree.states)
    if (const auto strength = tree.adhesion(origin, other.key); other.key != origin && strength)
      tree.set_adhesion(copy.key, other.key, strength);
  return tree.add(std::move(copy));
}

void TreeVariation::add(TreeGenes& tree, Rng& rng) const {
  add_copy(tree, any_of(open_parents(tree), rng), rng);
}

void TreeVariation::split(TreeGenes& tree, Rng& rng) const {
  const std::size_t above = any_of(divisible(tree), rng);
  const std::size_t between = add_copy(tree, above, rng);
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
  if (tree.skills != other.skills || tree.attributes != other.attributes)
    throw std::runtime_error("two trees of different skills or attributes cannot be crossed");
  for (TreeState& state : tree.states) {
    const auto twin = other.find(state.key);
    if (!twin) continue;
    if (rng.chance(0.5)) state.points = other.states[*twin].points;
    for (std::size_t k = 0; k < tree.attributes.size(); ++k)
      if (rng.chance(0.5)) state.attributes[k] = other.states[*twin].attributes[k];
  }
  graft(tree, other, rng);
  if (p_.evolve_adhesion) cross_pairs(tree, decode(first), other, rng);
  tree.sort();
  encode(tree, child);
}

void TreeVariation::graft(TreeGenes& tree, const TreeGenes& donor, Rng& rng) const {
  for (const TreeState& state : donor.states) {
    if (state.parent == no_parent || tree.find(state.key)) continue;
    const auto parent = tree.find(donor.states[state.parent].key);
    if (!parent || !rng.chance(0.5)) continue;
    tree.add({state.key, *parent, state.points, state.attributes});
    if (!fits(tree)) tree.remove(tree.states.size() - 1);
  }
}

double TreeVariation::distance(GenesView first, GenesView second) const {
  const TreeGenes a = decode(first), b = decode(second);
  if (a.skills != b.skills || a.attributes != b.attributes) return 1;
  double sum = 0;
  std::size_t shared = 0;
  for (const TreeState& state : a.states) {
    const auto twin = b.find(state.key);
    if (!twin) continue;
    ++shared;
    sum += state_distance(state, b.states[*twin]);
  }
  std::size_t all = a.states.size() + b.states.size() - shared;
  sum += static_cast<double>(all - shared);
  for (const AdhesionGene& pair : a.pairs) {
    const auto other = b.adhesion(pair.first, pair.second);
    sum += other ? relative(pair.strength - *other, p_.max_adhesion) : 1;
  }
  all += a.pairs.size();
  for (const AdhesionGene& pair : b.pairs)
    if (!a.adhesion(pair.first, pair.second)) ++all, ++sum;
  return sum / static_cast<double>(all);
}

double TreeVariation::state_distance(const TreeState& a, const TreeState& b) const {
  double apart = 0;
  for (std::size_t k = 0; k < a.points.size(); ++k)
    apart += std::abs(a.points[k] - b.points[k]) * (k < skills_.size() ? skills_[k].spec.cost : 1);
  double sum = std::min(1.0, 0.5 * apart / p_.budget);
  for (std::size_t k = 0; k < a.attributes.size(); ++k) {
    const double range =
        k < attributes_.size() ? attributes_[k].maximum - attributes_[k].minimum : 1;
    sum += relative(a.attributes[k] - b.attributes[k], range);
  }
  return sum / static_cast<double>(1 + a.attributes.size());
}

// ---- checks ----------------------------------------------------------------------------------

void TreeVariation::check(const Layout&, GenesView genes) const {
  static_cast<void>(fitting(genes));
}

TreeGenes TreeVariation::fitting(GenesView genes) const {
  TreeGenes tree = decode(genes);
  const bool same = std::ranges::equal(tree.skills, skills_, {}, {}, &EvolvingSkill::key);
  if (!same) throw std::runtime_error("the genes of the tree are for other skills");
  if (!std::ranges::equal(tree.attributes, attributes_, {}, {}, &EvolvingAttribute::key))
    throw std::runtime_error("the genes of the tree are for other evolving attributes");
  if (!attributes_fit(tree) || conformed_pairs(tree) != tree.pairs)
    throw std::runtime_error("an attribute or an adhesion of the tree is outside its range");
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
