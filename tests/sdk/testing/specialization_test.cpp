// Trees with one fault each, which check_specialization must find, and honest ones.
#include "somas/sdk/testing/specialization.hpp"

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<SkillInfo> skills = {{"capacity", {}}, {"speed", {.minimum = 1, .maximum = 4}}};
const std::vector<double> points = {0, 2};

using Grow = std::function<void(TreeSink&)>;

/// A fixed tree.
class Fixed final : public Specialization {
 public:
  using Parameters = Grow;
  explicit Fixed(const Grow& grow) : grow_(grow) {}
  void grow(GenesView, std::span<const SkillInfo>, TreeSink& tree) const override { grow_(tree); }

 private:
  Grow grow_;
};

Failures found(Grow grow) { return check_specialization<Fixed>(std::move(grow), skills); }

StateSpec state(std::string_view name, std::uint16_t parent = no_state) {
  return {.name = name, .parent = parent, .skills = points};
}

TEST(CheckSpecialization, FindsNothingInAnHonestTree) {
  EXPECT_THAT(found([](TreeSink& tree) {
                tree.add(state("root"));
                tree.add(state("leaf", 0));
              }),
              IsEmpty());
}

TEST(CheckSpecialization, FindsTreesThatAreNone) {
  EXPECT_THAT(found([](TreeSink&) {}), ElementsAre("grow: the tree has no states"));
  EXPECT_THAT(found([](TreeSink& tree) { tree.add(state("root", 0)); }),
              ElementsAre("grow: state 'root': one state, the first, is the root"));
  EXPECT_THAT(found([](TreeSink& tree) {
                tree.add(state("root"));
                tree.add(state("leaf", 1));
              }),
              ElementsAre("grow: state 'leaf': its parent must come before it"));
  EXPECT_THAT(found([](TreeSink& tree) {
                tree.add(state("root"));
                tree.add(state("root", 0));
              }),
              ElementsAre("grow: state 'root': the name is taken"));
  EXPECT_THAT(found([](TreeSink& tree) {
                tree.add(state("root"));
                StateSpec twin = state("leaf", 0);
                twin.key = stable_key("root");
                tree.add(twin);
              }),
              ElementsAre("grow: state 'leaf': the key is taken"));
}

TEST(CheckSpecialization, FindsNumbersOutOfRange) {
  const auto with = [](auto change) {
    return found([change](TreeSink& tree) {
      StateSpec root = state("root");
      change(root);
      tree.add(root);
    });
  };
  EXPECT_THAT(with([](StateSpec& s) { s.mass = 0; }), Contains(HasSubstr("mass")));
  EXPECT_THAT(with([](StateSpec& s) { s.radius = -1; }), Contains(HasSubstr("radius")));
  EXPECT_THAT(with([](StateSpec& s) { s.stiffness = -1; }), Contains(HasSubstr("stiffness")));
  EXPECT_THAT(with([](StateSpec& s) { s.adhesion_range = 0.5; }), Contains(HasSubstr("range")));
  const std::vector<double> too_fast = {0, 5}, too_few = {0};
  EXPECT_THAT(with([&](StateSpec& s) { s.skills = too_fast; }),
              ElementsAre("grow: state 'root': the skill 'speed' is out of its range"));
  EXPECT_THAT(with([&](StateSpec& s) { s.skills = too_few; }),
              Contains(HasSubstr("one value is needed for every skill")));
}

TEST(CheckSpecialization, FindsATreeThatChanges) {
  static int times;
  EXPECT_THAT(found([](TreeSink& tree) {
                tree.add(state("root"));
                if (++times % 2 == 0) tree.add(state("leaf", 0));
              }),
              Contains(HasSubstr("equal genes give another tree")));
}

/// A chain of states, one a gene; `most` is what mutation holds to.
class Chain final : public Specialization, private Heritable {
 public:
  struct Parameters {
    std::size_t most = 6;
  };
  explicit Chain(const Parameters& p) : p_(p) {}
  [[nodiscard]] const Heritable* heritable() const override { return this; }
  void grow(GenesView genes, std::span<const SkillInfo>, TreeSink& tree) const override {
    tree.add(state("root"));
    for (std::size_t i = 0; i < genes.size(); ++i) {
      if (i == 6) throw ParameterError("states", "seven are too many");
      const std::string name = "state_" + std::to_string(i);
      tree.add(state(name, static_cast<std::uint16_t>(i)));
    }
  }

 private:
  void random(const Layout&, Rng&, Genes& genes) const override { genes = {1}; }
  void conform(const Layout&, Rng&, Genes&) const override {}
  void mutate(const Layout&, Rng& rng, Genes& genes) const override {
    if (rng.chance(0.4) && !genes.empty())
      genes.pop_back();
    else if (genes.size() < p_.most)
      genes.push_back(1);
  }
  void cross(const Layout&, GenesView first, GenesView, Rng&, Genes& child) const override {
    child.assign(first.begin(), first.end());
  }
  [[nodiscard]] double distance(GenesView a, GenesView b) const override {
    return a.size() > b.size() ? static_cast<double>(a.size() - b.size())
                               : static_cast<double>(b.size() - a.size());
  }
  void to_json(GenesView genes, JsonWriter& out) const override {
    out.integer("states", static_cast<std::int64_t>(genes.size()));
  }
  void from_json(const JsonReader& in, Genes& genes) const override {
    genes.assign(static_cast<std::size_t>(in.member("states").integer()), 1);
  }
  void check(const Layout&, GenesView genes) const override {
    for (const std::uint8_t gene : genes)
      if (gene != 1) throw std::runtime_error("a gene is no 1");
  }

  Parameters p_;
};

TEST(CheckSpecialization, FindsNothingInAnHonestTreeThatEvolves) {
  EXPECT_THAT(check_specialization<Chain>({}, skills), IsEmpty());
}

TEST(CheckSpecialization, FindsGenesThatFitButGiveNoTree) {
  EXPECT_THAT(check_specialization<Chain>({.most = 9}, skills),
              Contains(::testing::MatchesRegex("grow after mutations: mutation [0-9]+: seven are "
                                               "too many")));
}

}  // namespace
}  // namespace somas::testing
