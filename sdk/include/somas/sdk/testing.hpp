/// @file
/// A conformance kit for the tests of plugins: whether a class keeps the SDK's contract. It needs
/// the SDK and the standard library only; a check returns what is wrong as readable sentences, so
/// any test framework will do:
///
/// @code
///   EXPECT_THAT(somas::testing::check_environment<Breeze>({.strength = 2}), ::testing::IsEmpty());
/// @endcode
///
/// check_environment, check_controller, check_specialization and check_fitness take a plugin class
/// and its parameters (or a function that makes instances), check_heritable any Heritable.
/// TestWorld is a small host of its own, for tests of single rules. Nothing here is part of a
/// plugin, of the binary boundary or of plugin.hpp: include it in tests.
#pragma once

#include "somas/sdk/testing/controller.hpp"
#include "somas/sdk/testing/declare.hpp"
#include "somas/sdk/testing/environment.hpp"
#include "somas/sdk/testing/failures.hpp"
#include "somas/sdk/testing/fitness.hpp"
#include "somas/sdk/testing/heritable.hpp"
#include "somas/sdk/testing/json.hpp"
#include "somas/sdk/testing/ports.hpp"
#include "somas/sdk/testing/specialization.hpp"
#include "somas/sdk/testing/world.hpp"
