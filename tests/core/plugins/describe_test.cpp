#include "core/plugins/describe.hpp"

#include <gtest/gtest.h>

namespace somas::plugins {
namespace {

struct Element {
  std::string name;
  double size = 2;
  std::optional<double> limit;
  std::map<std::string, double> points;

  void describe(Describe& d) {
    d("name", name, "What it is called", {.required = true});
    d("size", size, "How large", {.minimum = 0});
    d("limit", limit, "The most", {});
    d.table("points", points, "Points by name");
  }
};

// The YAML of a controller with these parameters.
std::string yaml_of(const Describe& parameters) {
  ClassInfo info;
  info.kind = PluginKind::controller;
  info.id = "toy";
  info.doc = "A toy";
  info.parameters = parameters.parameters().data();
  info.parameter_count = parameters.parameters().size();
  return describe(PluginClass{nullptr, &info}, DescribeFormat::yaml);
}

TEST(DescribeAsYaml, ARequiredListHasAnElementToPaste) {
  Describe d;
  std::vector<Element> elements;
  d.list("elements", elements, "The elements", true);
  EXPECT_EQ(yaml_of(d),
            "# A toy\n"
            "controller:\n"
            "  plugin: toy\n"
            "  # The elements (required)\n"
            "  elements:\n"
            "    - name: example  # What it is called (required)\n"
            "      size: 2  # How large; at least 0\n"
            "      # limit:  # The most (optional)\n"
            "      points: {}  # Points by name\n");
}

TEST(DescribeAsYaml, AnElementOfAnEmptyListIsTold) {
  Describe d;
  std::vector<Element> elements;
  d.list("elements", elements, "The elements");
  EXPECT_EQ(yaml_of(d),
            "# A toy\n"
            "controller:\n"
            "  plugin: toy\n"
            "  # The elements; an element is\n"
            "  # elements:\n"
            "  #   - name: example  # What it is called (required)\n"
            "  #     size: 2  # How large; at least 0\n"
            "  #     # limit:  # The most (optional)\n"
            "  #     points: {}  # Points by name\n"
            "  elements: []\n");
}

TEST(DescribeAsYaml, WhatIsRequiredHasAnExampleInRange) {
  Describe d;
  double any = 0, large = 0, small = 0;
  std::int64_t count = 0;
  std::vector<double> numbers;
  d("any", any, "Any", {.required = true});
  d("large", large, "Large", {.minimum = 10, .required = true});
  d("small", small, "Small",
    {.minimum = -2, .maximum = -1, .minimum_open = true, .required = true});
  d("count", count, "Count", {.minimum = 3, .required = true});
  d("numbers", numbers, "Numbers", {.minimum = 5, .required = true});
  EXPECT_EQ(yaml_of(d),
            "# A toy\n"
            "controller:\n"
            "  plugin: toy\n"
            "  any: 1  # Any (required)\n"
            "  large: 10  # Large; at least 10 (required)\n"
            "  small: -1  # Small; greater than -2, at most -1 (required)\n"
            "  count: 3  # Count; at least 3 (required)\n"
            "  numbers: [5]  # Numbers; at least 5 (required)\n");
}

}  // namespace
}  // namespace somas::plugins
