// Toys whose programs have one fault each, which check_controller must find, and an honest one.
#include "somas/sdk/testing/controller.hpp"

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>

#include <gmock/gmock.h>

namespace somas::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Eight bytes, whatever the layout.
class EightBytes final : public Heritable {
 public:
  void random(const Layout&, Rng& rng, Genes& genes) const override {
    genes.resize(8);
    for (std::uint8_t& gene : genes) gene = static_cast<std::uint8_t>(rng.below(256));
  }
  void conform(const Layout&, Rng&, Genes&) const override {}
  void mutate(const Layout&, Rng& rng, Genes& genes) const override {
    genes[rng.below(8)] = static_cast<std::uint8_t>(rng.below(256));
  }
  void cross(const Layout&, GenesView first, GenesView, Rng&, Genes& child) const override {
    child.assign(first.begin(), first.end());
  }
  [[nodiscard]] double distance(GenesView a, GenesView b) const override {
    double sum = 0;
    for (std::size_t i = 0; i < 8; ++i) sum += std::abs(double{0} + a[i] - b[i]);
    return sum;
  }
  void to_json(GenesView genes, JsonWriter& out) const override {
    out.open_list("genes");
    for (const std::uint8_t gene : genes) out.integer("", gene);
    out.close();
  }
  void from_json(const JsonReader& in, Genes& genes) const override {
    genes.clear();
    for (std::size_t i = 0; i < in.member("genes").size(); ++i)
      genes.push_back(static_cast<std::uint8_t>(in.member("genes").item(i).integer()));
  }
  void check(const Layout&, GenesView genes) const override {
    if (genes.size() != 8) throw std::runtime_error("not eight bytes");
  }
};

/// What a program does in one step.
using Step = std::function<void(const Batch&, float weight)>;

class ToyProgram final : public Program {
 public:
  ToyProgram(Step step, float weight, std::uint32_t memory)
      : step_(std::move(step)), weight_(weight), memory_(memory) {}
  [[nodiscard]] std::uint32_t memory_per_cell() const override { return memory_; }
  void step(const Batch& batch) const override { step_(batch, weight_); }

 private:
  Step step_;
  float weight_;
  std::uint32_t memory_;
};

/// Each output leaks towards the first input; the memory holds how far it is.
void honest(const Batch& batch, float weight) {
  for (std::uint32_t i = 0; i < batch.count; ++i) {
    float& level = batch.memory.channel(0)[i];
    level += weight * (batch.in.channel(0)[i] - level);
    for (std::uint32_t c = 0; c < batch.out.channels; ++c)
      batch.out.channel(c)[i] = level / static_cast<float>(c + 1);
  }
}

class Toy final : public Controller {
 public:
  struct Parameters {
    Step step = honest;
  };
  explicit Toy(const Parameters& p) : p_(p) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes, const Layout&) const override {
    return std::make_unique<ToyProgram>(p_.step, static_cast<float>(genes[0]) / 256, 1);
  }

 private:
  Parameters p_;
  EightBytes genes_;
};

/// What is found when a program does `more` after an honest step.
Failures found(Step more) {
  return check_controller<Toy>({[more](const Batch& batch, float weight) {
    honest(batch, weight);
    more(batch, weight);
  }});
}

TEST(CheckController, FindsNothingInAnHonestOne) {
  EXPECT_THAT(check_controller<Toy>(), IsEmpty());
}

TEST(CheckController, FindsAnOutputLeftUnwritten) {
  const Failures failures = check_controller<Toy>({[](const Batch& batch, float) {
    for (std::uint32_t c = 1; c < batch.out.channels; ++c)
      for (float& out : batch.out.channel(c)) out = 0.5f;
  }});
  EXPECT_THAT(failures, ElementsAre("step (layout 0): the output 'quiescence' is left unwritten",
                                    "step (layout 1): the output 'quiescence' is left unwritten",
                                    "step (layout 2): the output 'uptake.food' is left unwritten"));
}

TEST(CheckController, FindsNaN) {
  EXPECT_THAT(found([](const Batch& batch, float) {
                batch.out.channel(1)[0] = std::sqrt(-1 - batch.in.channel(0)[0]);
              }),
              Contains(HasSubstr("the output 'division' becomes NaN")));
}

TEST(CheckController, FindsLanesThatDependOnTheBatch) {
  EXPECT_THAT(found([](const Batch& batch, float) {
                float sum = 0;
                for (const float in : batch.in.channel(0)) sum += in;
                for (float& out : batch.out.channel(0)) out = sum;
              }),
              Contains(HasSubstr("a batch split into smaller ones (layout 0): outputs or memory")));
}

TEST(CheckController, FindsLanesThatDependOnTheirPlace) {
  EXPECT_THAT(found([](const Batch& batch, float) {
                for (std::uint32_t i = 0; i < batch.count; ++i)
                  batch.out.channel(0)[i] += i % 2 == 0 ? 0.0f : 1e-3f;
              }),
              Contains(HasSubstr("cells in other lanes (layout 0)")));
}

TEST(CheckController, FindsStateInTheProgram) {
  static std::atomic<int> steps;
  EXPECT_THAT(found([](const Batch& batch, float) {
                const auto number = static_cast<float>(++steps);
                for (float& out : batch.out.channel(0)) out = number;
              }),
              Contains(HasSubstr("a second run of one program (layout 0)")));
}

TEST(CheckController, FindsWritesBeyondTheLanes) {
  EXPECT_THAT(found([](const Batch& batch, float) { batch.out.data[batch.count] = 0; }),
              Contains("step (layout 0): writes outside the rows and lanes of its batch"));
  EXPECT_THAT(found([](const Batch& batch, float) {
                batch.memory.data[batch.memory.channels * batch.memory.stride] = 0;
              }),
              Contains("step (layout 0): writes outside the rows and lanes of its batch"));
}

TEST(CheckController, FindsReadsBeyondTheLanes) {
  EXPECT_THAT(found([](const Batch& batch, float) {
                if (!(batch.in.data[batch.in.stride - 1] == -7.25f)) batch.out.channel(0)[0] = 9;
              }),
              Contains(HasSubstr("other values beyond the lanes (layout 0)")));
}

TEST(CheckController, FindsOutputsThatAreReadBeforeTheyAreWritten) {
  const Failures failures = check_controller<Toy>({[](const Batch& batch, float weight) {
    const float before = batch.out.channel(0)[0];
    honest(batch, weight);
    if (before > 0.5f) batch.out.channel(0)[0] = before;
  }});
  EXPECT_THAT(failures, Contains(HasSubstr("other values in the outputs before a step")));
}

/// Expresses another program each time.
class Fickle final : public Controller {
 public:
  struct Parameters {};
  explicit Fickle(const Parameters&) {}
  [[nodiscard]] const Heritable& heritable() const override { return genes_; }
  [[nodiscard]] std::unique_ptr<Program> express(GenesView genes, const Layout&) const override {
    const auto weight = static_cast<float>(genes[0] + ++expressed_) / 512;
    return std::make_unique<ToyProgram>(honest, weight, 1);
  }

 private:
  EightBytes genes_;
  mutable std::atomic<int> expressed_ = 0;
};

TEST(CheckController, FindsExpressionThatDependsOnThePast) {
  EXPECT_THAT(check_controller<Fickle>(),
              Contains(HasSubstr("express by a second instance (layout 0)")));
}

}  // namespace
}  // namespace somas::testing
