// Toys that break one law of heredity each, which check_heritable must find, and an honest one.
#include "somas/sdk/testing/heritable.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A number in [0, 1) for each input port, in ascending order of keys: (key, number) pairs.
class Honest : public Heritable {
 public:
  using Pairs = std::vector<std::pair<std::uint64_t, double>>;

  void random(const Layout& layout, Rng& rng, Genes& genes) const override {
    Pairs pairs;
    for (const std::uint64_t key : keys_of(layout)) pairs.emplace_back(key, rng.uniform());
    genes = encode(pairs);
  }
  void conform(const Layout& layout, Rng& rng, Genes& genes) const override {
    const Pairs old = decode(genes);
    Pairs pairs;
    for (const std::uint64_t key : keys_of(layout)) {
      const auto known =
          std::find_if(old.begin(), old.end(), [&](const auto& pair) { return pair.first == key; });
      pairs.emplace_back(key, known != old.end() ? known->second : rng.uniform());
    }
    genes = encode(pairs);
  }
  void mutate(const Layout&, Rng& rng, Genes& genes) const override {
    Pairs pairs = decode(genes);
    if (!pairs.empty()) pairs[rng.below(pairs.size())].second = rng.uniform();
    genes = encode(pairs);
  }
  void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
             Genes& child) const override {
    Pairs pairs = decode(first);
    for (const auto& pair : decode(second)) {
      const auto known = std::find_if(pairs.begin(), pairs.end(),
                                      [&](const auto& one) { return one.first == pair.first; });
      if (known == pairs.end())
        pairs.push_back(pair);
      else if (rng.chance(0.5))
        known->second = pair.second;
    }
    child = encode(pairs);
    conform(layout, rng, child);
  }
  [[nodiscard]] double distance(GenesView first, GenesView second) const override {
    const Pairs a = decode(first), b = decode(second);
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i].second - b[i].second);
    return sum;
  }
  void to_json(GenesView genes, JsonWriter& out) const override {
    out.open_list("pairs");
    for (const auto& [key, number] : decode(genes)) {
      out.open_object("");
      out.key64("key", key);
      out.number("number", written(number));
      out.close();
    }
    out.close();
  }
  void from_json(const JsonReader& in, Genes& genes) const override {
    Pairs pairs;
    const JsonReader& list = in.member("pairs");
    for (std::size_t i = 0; i < list.size(); ++i)
      pairs.emplace_back(list.item(i).member("key").key64(),
                         list.item(i).member("number").number());
    genes = encode(pairs);
  }
  void check(const Layout& layout, GenesView genes) const override {
    const std::vector<std::uint64_t> keys = keys_of(layout);
    if (genes.size() != 16 * keys.size()) throw std::runtime_error("another number of ports");
    const Pairs pairs = decode(genes);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (pairs[i].first != keys[i] || !(pairs[i].second >= 0 && pairs[i].second < 1))
        throw std::runtime_error("no pair of this layout");
  }

 protected:
  [[nodiscard]] virtual double written(double number) const { return number; }
  static std::vector<std::uint64_t> keys_of(const Layout& layout) {
    std::vector<std::uint64_t> keys;
    for (const Port& port : layout.inputs) keys.push_back(port.key);
    std::sort(keys.begin(), keys.end());
    return keys;
  }
  static Genes encode(const Pairs& pairs) {
    Genes genes(16 * pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      std::memcpy(&genes[16 * i], &pairs[i].first, 8);
      std::memcpy(&genes[16 * i + 8], &pairs[i].second, 8);
    }
    return genes;
  }
  static Pairs decode(GenesView genes) {
    Pairs pairs(genes.size() / 16);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      std::memcpy(&pairs[i].first, &genes[16 * i], 8);
      std::memcpy(&pairs[i].second, &genes[16 * i + 8], 8);
    }
    return pairs;
  }
};

Failures found(const Heritable& heritable) {
  const std::vector<PortTable> ports = usual_ports();
  std::vector<Layout> layouts;
  for (const PortTable& table : ports) layouts.push_back(table.layout());
  return check_heritable(heritable, layouts);
}

TEST(CheckHeritable, FindsNothingInAnHonestOne) { EXPECT_THAT(found(Honest{}), IsEmpty()); }

TEST(CheckHeritable, FindsMutationsThatLeaveTheRange) {
  class Faulty final : public Honest {
    void mutate(const Layout&, Rng& rng, Genes& genes) const override {
      Pairs pairs = decode(genes);
      pairs[0].second += rng.uniform();
      genes = encode(pairs);
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("mutations do not fit: no pair")));
}

TEST(CheckHeritable, FindsAChildOfOneParentThatIsAnother) {
  class Faulty final : public Honest {
    void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
               Genes& child) const override {
      Honest::cross(layout, first, second, rng, child);
      mutate(layout, rng, child);
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains("cross (layout 0): the child of a parent with itself is "
                                        "not that parent"));
}

TEST(CheckHeritable, FindsChildrenThatKeepOldContent) {
  class Faulty final : public Honest {
    void cross(const Layout&, GenesView first, GenesView, Rng&, Genes& child) const override {
      if (child.size() < first.size()) child.assign(first.begin(), first.end());
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("old content of the child makes a difference")));
}

TEST(CheckHeritable, FindsRandomGenesThatKeepOldContent) {
  class Faulty final : public Honest {
    void random(const Layout& layout, Rng& rng, Genes& genes) const override {
      if (genes.empty()) Honest::random(layout, rng, genes);
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("old content of the genes makes a difference")));
}

TEST(CheckHeritable, FindsJsonThatRounds) {
  class Faulty final : public Honest {
    [[nodiscard]] double written(double number) const override {
      return static_cast<float>(number);
    }
  };
  EXPECT_THAT(found(Faulty{}),
              Contains(HasSubstr("JSON (layout 0): genes read back differ from those written")));
}

TEST(CheckHeritable, FindsJsonThatIsNone) {
  class Faulty final : public Honest {
    void to_json(GenesView, JsonWriter& out) const override { out.open_list("pairs"); }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("JSON: a close() is missing")));
}

TEST(CheckHeritable, FindsDistancesThatAreNone) {
  class Lopsided final : public Honest {
    [[nodiscard]] double distance(GenesView first, GenesView second) const override {
      const bool ascending =
          std::lexicographical_compare(first.begin(), first.end(), second.begin(), second.end());
      return (ascending ? 2 : 1) * Honest::distance(first, second);
    }
  };
  EXPECT_THAT(found(Lopsided{}), Contains(HasSubstr("one way")));
  class Negative final : public Honest {
    [[nodiscard]] double distance(GenesView first, GenesView second) const override {
      return -Honest::distance(first, second);
    }
  };
  EXPECT_THAT(found(Negative{}), Contains(HasSubstr("is no distance")));
  class Offset final : public Honest {
    [[nodiscard]] double distance(GenesView first, GenesView second) const override {
      return 1 + Honest::distance(first, second);
    }
  };
  EXPECT_THAT(found(Offset{}), Contains(HasSubstr("of genes to themselves is 1, not 0")));
}

TEST(CheckHeritable, FindsConformThatChangesWhatFits) {
  class Faulty final : public Honest {
    void conform(const Layout& layout, Rng& rng, Genes& genes) const override {
      Honest::conform(layout, rng, genes);
      mutate(layout, rng, genes);
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains("conform (layout 0): genes that fit already are changed"));
}

TEST(CheckHeritable, FindsConformThatDoesNotMatchPortsByKey) {
  class Faulty final : public Honest {
    void conform(const Layout& layout, Rng& rng, Genes& genes) const override {
      try {
        check(layout, genes);
      } catch (const std::runtime_error&) {
        random(layout, rng, genes);
      }
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("conform to layout 1 (layout 0): genes that were "
                                                  "given more ports and lost them again")));
}

TEST(CheckHeritable, FindsConformedGenesThatDoNotFit) {
  class Faulty final : public Honest {
    void conform(const Layout&, Rng&, Genes&) const override {}
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("conformed genes do not fit")));
}

TEST(CheckHeritable, FindsCrossingThatKnowsNoOtherPortsThanTheFirstParents) {
  class Faulty final : public Honest {
    void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
               Genes& child) const override {
      Pairs pairs = decode(first);
      const Pairs other = decode(second);
      for (std::size_t i = 0; i < std::min(pairs.size(), other.size()); ++i)
        if (pairs[i].first == other[i].first && rng.chance(0.5)) pairs[i].second = other[i].second;
      child = encode(pairs);
      conform(layout, rng, child);
    }
  };
  EXPECT_THAT(found(Faulty{}),
              Contains(HasSubstr("a parent and itself with fewer ports have another child")));
}

TEST(CheckHeritable, FindsCrossingThatMixesFreshPortsIn) {
  class Faulty final : public Honest {
    void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
               Genes& child) const override {
      Genes mother(first.begin(), first.end()), father(second.begin(), second.end());
      conform(layout, rng, mother);
      conform(layout, rng, father);
      Honest::cross(layout, mother, father, rng, child);
    }
  };
  EXPECT_THAT(found(Faulty{}),
              Contains(HasSubstr("a parent and itself with fewer ports have another child")));
}

TEST(CheckHeritable, FindsChildrenWithPortsThatTheirLayoutLacks) {
  class Faulty final : public Honest {
    void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
               Genes& child) const override {
      Honest::cross(layout, first, second, rng, child);
      if (first.size() > child.size()) child.assign(first.begin(), first.end());
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("do not fit")));
}

TEST(CheckHeritable, FindsChanceFromElsewhere) {
  class Faulty final : public Honest {
    void mutate(const Layout& layout, Rng& rng, Genes& genes) const override {
      const int skipped = ++calls_ % 3;
      for (int i = 0; i < skipped; ++i) static_cast<void>(rng.bits());
      Honest::mutate(layout, rng, genes);
    }
    mutable std::atomic<int> calls_ = 0;
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("equal streams give other genes")));
}

TEST(CheckHeritable, FindsBytesThatAreNotCanonical) {
  class Faulty final : public Honest {
    void check(const Layout& layout, GenesView genes) const override {
      Honest::check(layout, genes.first(genes.size() / 16 * 16));
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains(HasSubstr("two lists of bytes that mean the same genes")));
}

TEST(CheckHeritable, FindsDamageThatEndsInAnotherError) {
  class Faulty final : public Honest {
    void check(const Layout& layout, GenesView genes) const override {
      if (genes.size() % 16 != 0) throw std::logic_error("lost my place");
      Honest::check(layout, genes);
    }
  };
  EXPECT_THAT(found(Faulty{}), Contains("check of damaged genes (layout 0): lost my place"));
}

TEST(JsonTree, RefusesWhatIsNoJson) {
  JsonTree tree;
  EXPECT_THROW(tree.number("x", std::nan("")), std::logic_error);
  EXPECT_THROW(tree.number("", 1), std::logic_error);
  tree.number("x", 1.5);
  EXPECT_THROW(tree.number("x", 1), std::logic_error);
  EXPECT_THROW(tree.close(), std::logic_error);
  tree.open_list("list");
  EXPECT_THROW(tree.number("y", 1), std::logic_error);
  tree.integer("", 7);
  EXPECT_THROW(static_cast<void>(tree.root()), std::logic_error);
  tree.close();

  const JsonReader& root = tree.root();
  EXPECT_EQ(root.member("x").number(), 1.5);
  EXPECT_EQ(root.member("list").item(0).number(), 7);
  EXPECT_FALSE(root.has("y"));
  EXPECT_THROW(static_cast<void>(root.member("y")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(root.member("x").integer()), std::runtime_error);
  EXPECT_THROW(static_cast<void>(root.member("list").item(1)), std::runtime_error);
}

}  // namespace
}  // namespace somas::testing
