/// @file
/// The conformance check of what evolves: the laws of heritable.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "somas/sdk/heritable.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/json.hpp"
#include "somas/sdk/testing/ports.hpp"

namespace somas::testing {

/// How check_heritable looks at a heritable part.
struct HeritableOptions {
  std::uint64_t genomes = 12;    ///< drawn for each layout
  std::uint64_t mutations = 40;  ///< events that the last of them has been through; the first: none
  std::uint64_t seed = 1;        ///< of all chance
  /// Genes that are conformed to a layout that holds all ports of theirs, and back, are the same.
  bool conforms_back = true;
};

namespace detail {

/// The single laws, over one layout or two; each throws what it finds.
class HeritableCheck {
 public:
  HeritableCheck(const Heritable& heritable, std::span<const Layout> layouts,
                 const HeritableOptions& options)
      : heritable_(heritable), layouts_(layouts), options_(options) {}

  /// The checks, which keep `it`.
  [[nodiscard]] static Checks list(const std::shared_ptr<HeritableCheck>& it);

 private:
  /// The genes that are looked at, drawn when they are first asked for.
  [[nodiscard]] const std::vector<Genes>& all(std::size_t layout);
  [[nodiscard]] Rng stream(const char* purpose, std::uint64_t entity) const {
    return {options_.seed, 0, 0, stable_key(purpose), entity};
  }
  [[nodiscard]] Genes evolved(const Layout& layout, std::uint64_t number) const;
  void require_fit(const Layout& layout, GenesView genes, const std::string& what) const;
  [[nodiscard]] Bytes everything(const Layout& layout, std::uint64_t number) const;

  void fits(const Layout& layout, const std::vector<Genes>& all) const;
  void replaces_old_content(const Layout& layout) const;
  void hangs_on_the_stream(const Layout& layout) const;
  void crosses(const Layout& layout, const std::vector<Genes>& all) const;
  void measures(const std::vector<Genes>& all) const;
  void writes_json(const Layout& layout, const std::vector<Genes>& all) const;
  void leaves_fitting_genes(const Layout& layout, const std::vector<Genes>& all) const;
  void refuses_or_keeps(const Layout& layout, const Genes& genes) const;
  void conforms(const Layout& from, const Layout& to) const;
  void crosses_layouts(const Layout& own, const Layout& other) const;

  const Heritable& heritable_;
  std::span<const Layout> layouts_;
  HeritableOptions options_;
  std::vector<std::vector<Genes>> drawn_{};
};

/// Genes written as JSON and read again.
inline Genes through_json(const Heritable& heritable, GenesView genes) {
  JsonTree tree;
  heritable.to_json(genes, tree);
  Genes back = {1, 2, 3};
  heritable.from_json(tree.root(), back);
  return back;
}

inline Checks HeritableCheck::list(const std::shared_ptr<HeritableCheck>& it) {
  Checks checks;
  const std::string chance = "chance from the stream alone";
  for (std::size_t l = 0; l < it->layouts_.size(); ++l) {
    const std::string of = it->layouts_.size() == 1 ? "" : " (layout " + std::to_string(l) + ")";
    const auto add = [&](const std::string& law, const std::string& name, const char* remedy,
                         auto body, std::vector<std::string> needs = {}) {
      checks.push_back({.law = law,
                        .name = name + of,
                        .remedy = remedy,
                        .body = [it, l, body] { body(*it, it->layouts_[l], it->all(l)); },
                        .needs = std::move(needs),
                        .scope = of});
    };
    using All = std::vector<Genes>;
    using It = HeritableCheck;
    add("random and mutate", "random and mutate",
        "random and mutate must give genes that check() takes for the layout",
        [](const It& c, const Layout& layout, const All& all) { c.fits(layout, all); });
    checks.back().first = true;
    add("random", "random", "clear the genes before you draw new ones",
        [](const It& c, const Layout& layout, const All&) { c.replaces_old_content(layout); });
    add("cross", "cross",
        "every gene of a child comes from a parent: of equal parents the child is their equal",
        [](const It& c, const Layout& layout, const All& all) { c.crosses(layout, all); });
    add("distance", "distance", "return 0 for equal genes, and the same number >= 0 both ways",
        [](const It& c, const Layout&, const All& all) { c.measures(all); });
    add("JSON", "JSON",
        "write every gene to the last bit (JsonWriter keeps doubles exactly), and read it back",
        [](const It& c, const Layout& layout, const All& all) { c.writes_json(layout, all); });
    add("conform", "conform", "leave genes alone that fit the layout already",
        [](const It& c, const Layout& layout, const All& all) {
          c.leaves_fitting_genes(layout, all);
        });
    add(chance, chance,
        "draw from the Rng that is handed in; no statics, no clock, no addresses, nothing kept "
        "from call to call",
        [](const It& c, const Layout& layout, const All&) { c.hangs_on_the_stream(layout); },
        {"cross", "distance", "JSON", "conform"});
    add("check of damaged genes", "check of damaged genes",
        "refuse, with std::runtime_error, whatever no operator makes: look at lengths, counts and "
        "ranges before you use them",
        [](const It& c, const Layout& layout, const All& all) {
          c.refuses_or_keeps(layout, all.back());
        },
        {"JSON"});
    for (std::size_t m = 0; m < it->layouts_.size(); ++m) {
      if (m == l) continue;
      const std::string other = std::to_string(m);
      add("conform to other ports", "conform to layout " + other,
          "match ports by key, drop those that are gone, draw those that are new from the Rng",
          [m](const It& c, const Layout& layout, const All&) { c.conforms(layout, c.layouts_[m]); },
          {chance, "conform"});
      add("cross with other ports", "cross with layout " + other,
          "match ports by key: what only one parent has comes from that one, whole",
          [m](const It& c, const Layout& layout, const All&) {
            c.crosses_layouts(layout, c.layouts_[m]);
          },
          {chance, "cross", "conform", "conform to other ports"});
    }
  }
  return checks;
}

inline const std::vector<Genes>& HeritableCheck::all(std::size_t layout) {
  drawn_.resize(layouts_.size());
  if (drawn_[layout].empty()) {
    std::vector<Genes> genes;
    for (std::uint64_t i = 0; i < options_.genomes; ++i)
      genes.push_back(evolved(layouts_[layout], i));
    drawn_[layout] = std::move(genes);
  }
  return drawn_[layout];
}

/// Random genes; the last of them has been through all mutations, the first through none.
inline Genes HeritableCheck::evolved(const Layout& layout, std::uint64_t number) const {
  Rng rng = stream("evolved", number);
  Genes genes;
  heritable_.random(layout, rng, genes);
  require_fit(layout, genes, "random genes");
  const std::uint64_t last = std::max<std::uint64_t>(1, options_.genomes - 1);
  for (std::uint64_t i = 0; i < options_.mutations * number / last; ++i) {
    heritable_.mutate(layout, rng, genes);
    require_fit(layout, genes, "genes after " + std::to_string(i + 1) + " mutations");
  }
  return genes;
}

inline void HeritableCheck::require_fit(const Layout& layout, GenesView genes,
                                        const std::string& what) const {
  try {
    heritable_.check(layout, genes);
  } catch (const std::exception& error) {
    throw std::runtime_error(what + " do not fit: " + error.what());
  }
}

inline void HeritableCheck::fits(const Layout& layout, const std::vector<Genes>& all) const {
  for (const Genes& genes : all) require_fit(layout, genes, "genes looked at a second time");
}

inline void HeritableCheck::replaces_old_content(const Layout& layout) const {
  Rng rng = stream("old", 0), same = rng;
  Genes fresh, used(999, 0xAB);
  heritable_.random(layout, rng, fresh);
  heritable_.random(layout, same, used);
  if (fresh != used) throw std::runtime_error("old content of the genes makes a difference");
}

/// All calls once, as bytes.
inline Bytes HeritableCheck::everything(const Layout& layout, std::uint64_t number) const {
  Bytes out;
  const auto keep = [&](const Genes& genes) { out.insert(out.end(), genes.begin(), genes.end()); };
  const Genes first = evolved(layout, number), second = evolved(layout, number + 1);
  Rng rng = stream("everything", number);
  Genes child;
  heritable_.cross(layout, first, second, rng, child);
  keep(first), keep(second), keep(child);
  heritable_.mutate(layout, rng, child);
  keep(child);
  keep(through_json(heritable_, child));
  for (const Layout& other : layouts_) {
    Genes conformed = child;
    heritable_.conform(other, rng, conformed);
    keep(conformed);
  }
  ByteWriter number_of;
  number_of.value(heritable_.distance(first, second));
  keep(number_of.bytes());
  return out;
}

inline void HeritableCheck::hangs_on_the_stream(const Layout& layout) const {
  constexpr std::size_t count = 4;
  std::array<Bytes, count> expected, threaded;
  for (std::size_t i = 0; i < count; ++i) expected[i] = everything(layout, i);
  for (std::size_t i = count; i-- > 0;)
    if (everything(layout, i) != expected[i])
      throw std::runtime_error("equal streams give other genes the second time");
  on_threads(count, [&](std::size_t i) {
    for (int again = 0; again < 3; ++again) threaded[i] = everything(layout, i);
  });
  if (threaded != expected)
    throw std::runtime_error("equal streams give other genes when several threads call");
}

inline void HeritableCheck::crosses(const Layout& layout, const std::vector<Genes>& all) const {
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Genes& mate = all[(i + 1) % all.size()];
    Rng rng = stream("cross", i), same = rng;
    Genes child, used(999, 0xAB);
    heritable_.cross(layout, all[i], mate, rng, child);
    require_fit(layout, child, "children");
    heritable_.cross(layout, all[i], mate, same, used);
    if (child != used) throw std::runtime_error("old content of the child makes a difference");
    heritable_.cross(layout, all[i], all[i], rng, child);
    if (child != all[i])
      throw std::runtime_error("the child of a parent with itself is not that parent");
  }
}

inline void HeritableCheck::measures(const std::vector<Genes>& all) const {
  for (const Genes& a : all) {
    if (const double self = heritable_.distance(a, a); self != 0)
      throw std::runtime_error("of genes to themselves is " + text_of(self) + ", not 0");
    for (const Genes& b : all) {
      const double there = heritable_.distance(a, b), back = heritable_.distance(b, a);
      if (!(there >= 0 && std::isfinite(there)))
        throw std::runtime_error(text_of(there) + " is no distance");
      if (there != back)
        throw std::runtime_error(text_of(there) + " one way, " + text_of(back) + " the other");
    }
  }
}

inline void HeritableCheck::writes_json(const Layout& layout, const std::vector<Genes>& all) const {
  for (const Genes& genes : all) {
    const Genes back = through_json(heritable_, genes);
    require_fit(layout, back, "genes read back");
    if (back != genes) throw std::runtime_error("genes read back differ from those written");
  }
}

inline void HeritableCheck::leaves_fitting_genes(const Layout& layout,
                                                 const std::vector<Genes>& all) const {
  for (std::size_t i = 0; i < all.size(); ++i) {
    Rng rng = stream("conform", i);
    Genes genes = all[i];
    heritable_.conform(layout, rng, genes);
    if (genes != all[i]) throw std::runtime_error("genes that fit already are changed");
  }
}

/// Bytes that nothing made are refused with std::runtime_error, or are the only ones of their
/// meaning.
inline void HeritableCheck::refuses_or_keeps(const Layout& layout, const Genes& genes) const {
  std::vector<Genes> damaged(3, genes);
  damaged[0].push_back(0);
  if (!genes.empty()) damaged[1].pop_back();
  damaged[2].resize(genes.size() / 2);
  Rng rng = stream("damage", 0);
  for (std::size_t i = 0; i < 300 && !genes.empty(); ++i) {
    Genes& flipped = damaged.emplace_back(genes);
    // The first bytes, where counts stand, come in for more.
    const std::size_t reach = i % 2 == 0 ? genes.size() : std::min<std::size_t>(32, genes.size());
    flipped[rng.below(reach)] ^= static_cast<std::uint8_t>(1u << rng.below(8));
  }
  for (const Genes& bytes : damaged) {
    try {
      heritable_.check(layout, bytes);
    } catch (const std::runtime_error&) {
      continue;
    }
    if (through_json(heritable_, bytes) != bytes)
      throw std::runtime_error("two lists of bytes that mean the same genes are both let pass");
  }
}

/// Whether every port of `part` is one of `whole`.
inline bool holds(const Layout& whole, const Layout& part) {
  const auto within = [](std::span<const Port> all, std::span<const Port> some) {
    std::set<std::uint64_t> keys;
    for (const Port& port : all) keys.insert(port.key);
    return std::all_of(some.begin(), some.end(),
                       [&](const Port& port) { return keys.contains(port.key); });
  };
  return within(whole.inputs, part.inputs) && within(whole.outputs, part.outputs);
}

inline void HeritableCheck::conforms(const Layout& from, const Layout& to) const {
  for (std::uint64_t i = 0; i < options_.genomes; ++i) {
    const Genes original = evolved(from, i);
    Rng rng = stream("conforms", i), same = rng;
    Genes genes = original, again = original;
    heritable_.conform(to, rng, genes);
    require_fit(to, genes, "conformed genes");
    heritable_.conform(to, same, again);
    if (again != genes) throw std::runtime_error("equal streams conform differently");
    heritable_.conform(from, rng, genes);
    require_fit(from, genes, "genes conformed back");
    if (options_.conforms_back && holds(to, from) && genes != original)
      throw std::runtime_error("genes that were given more ports and lost them again are changed");
  }
}

/// Parents of different trees: what only one of them has is handed down whole.
inline void HeritableCheck::crosses_layouts(const Layout& own, const Layout& other) const {
  for (std::uint64_t i = 0; i < options_.genomes; ++i) {
    const Genes genes = evolved(own, i), mate = evolved(other, i + 1);
    Rng rng = stream("crosses", i);
    Genes child;
    heritable_.cross(own, genes, mate, rng, child);
    require_fit(own, child, "children of a mate of this layout");
    heritable_.cross(other, genes, mate, rng, child);
    require_fit(other, child, "children of their mate's layout");
    if (!options_.conforms_back || !holds(own, other)) continue;
    Genes less = genes;
    heritable_.conform(other, rng, less);
    for (const bool swap : {false, true}) {
      heritable_.cross(own, swap ? less : genes, swap ? genes : less, rng, child);
      if (child != genes)
        throw std::runtime_error(
            "a parent and itself with fewer ports have another child than that parent");
    }
    heritable_.cross(other, genes, genes, rng, child);
    if (child != less)
      throw std::runtime_error(
          "the child of a parent with itself keeps ports otherwise than "
          "conform does");
  }
}

}  // namespace detail

/// The checks of check_heritable, one by one. What they look at must outlive them.
[[nodiscard]] inline Checks heritable_checks(const Heritable& heritable,
                                             std::span<const Layout> layouts,
                                             const HeritableOptions& options = {}) {
  return detail::HeritableCheck::list(
      std::make_shared<detail::HeritableCheck>(heritable, layouts, options));
}

/// Whether a heritable part keeps the laws of heritable.hpp, for genes of every layout in `layouts`
/// (trees that evolve: one empty Layout), and from each to every other. Each failure names the law:
/// random, mutated, crossed and conformed genes fit; `cross` of a parent with itself, whole or less
/// some ports, is the parent; distances; JSON to the last byte; `conform` leaves what fits; equal
/// streams give equal bytes, in any order and on several threads; damaged bytes are refused with
/// std::runtime_error, or are canonical.
[[nodiscard]] inline Failures check_heritable(const Heritable& heritable,
                                              std::span<const Layout> layouts,
                                              const HeritableOptions& options = {}) {
  return detail::run(heritable_checks(heritable, layouts, options));
}

}  // namespace somas::testing
