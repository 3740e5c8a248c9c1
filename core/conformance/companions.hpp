// The least parts of an experiment beside the one that is examined: nobody has to be installed.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "somas/sdk/controller.hpp"
#include "somas/sdk/environment.hpp"
#include "somas/sdk/fitness.hpp"
#include "somas/sdk/specialization.hpp"
#include "somas/sdk/testing/environment.hpp"

namespace somas::conformance {

/// Skills of the usual names, for trees that are examined.
inline constexpr std::string_view usual_skills[] = {"production", "resistance"};

/// Food everywhere, which grows back.
class CompanionMeadow final : public Environment {
 public:
  explicit CompanionMeadow(bool with_usual_skills) : with_usual_skills_(with_usual_skills) {}
  void declare(Declare& declare) override;
  void act(Phase phase, World& world) const override;

 private:
  bool with_usual_skills_;
  Id grid_ = no_id;
};

/// Nothing but variable parameters, for an environment that sets those of others.
class CompanionTaps final : public Environment {
 public:
  explicit CompanionTaps(std::vector<testing::EnvironmentOptions::OfOthers> taps)
      : taps_(std::move(taps)) {}
  void declare(Declare& declare) override;
  void act(Phase, World&) const override {}

 private:
  std::vector<testing::EnvironmentOptions::OfOthers> taps_;
};

/// A root and a child, each able to do something of everything.
class CompanionTree final : public Specialization {
 public:
  void grow(GenesView genes, std::span<const SkillInfo> skills, TreeSink& tree) const override;
};

/// No genes: what an output is hangs on its name, the cell's energy and a little on all that it
/// senses, so that cells divide, specialize, eat and send morphogens.
class CompanionController final : public Controller, private Heritable {
 public:
  [[nodiscard]] const Heritable& heritable() const override { return *this; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes,
                                                 const Layout& layout) const override;

 private:
  void random(const Layout&, Rng&, Genes& genes) const override { genes.clear(); }
  void conform(const Layout&, Rng&, Genes& genes) const override { genes.clear(); }
  void mutate(const Layout&, Rng&, Genes&) const override {}
  void cross(const Layout&, GenesView, GenesView, Rng&, Genes& child) const override {
    child.clear();
  }
  [[nodiscard]] double distance(GenesView, GenesView) const override { return 0; }
  void to_json(GenesView, JsonWriter&) const override {}
  void from_json(const JsonReader&, Genes& genes) const override { genes.clear(); }
  void check(const Layout&, GenesView) const override {}
};

/// Steps survived.
class CompanionFitness final : public Fitness {
 public:
  [[nodiscard]] std::string_view objective() const override { return "survival"; }
  [[nodiscard]] double score(const Outcome& outcome) const override {
    return static_cast<double>(outcome.survival);
  }
};

}  // namespace somas::conformance
