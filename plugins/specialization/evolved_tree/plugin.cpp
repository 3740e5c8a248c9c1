#include "somas/sdk/plugin.hpp"

#include "plugins/specialization/evolved_tree/evolved_tree.hpp"

SOMAS_PLUGIN("somas.evolved_tree", "0.1.0", somas::specialization::EvolvedTree)
