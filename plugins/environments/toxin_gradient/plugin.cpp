#include "somas/sdk/plugin.hpp"

#include "plugins/environments/toxin_gradient/toxin_gradient.hpp"

SOMAS_PLUGIN("somas.toxin_gradient", "0.1.0", somas::environments::ToxinGradient)
