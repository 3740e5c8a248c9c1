#include "somas/sdk/plugin.hpp"

#include "plugins/specialization/tree/tree.hpp"

SOMAS_PLUGIN("somas.tree", "0.1.0", somas::specialization::Tree)
