// Exports a function for every type that crosses the boundary, so that its debug information tells
// the whole interface to abidw.
#include <somas/sdk/plugin.hpp>

#define SOMAS_PROBE(type, name) \
  extern "C" __attribute__((visibility("default"))) void probe_##name(type*) {}

SOMAS_PROBE(somas::Batch, batch)
SOMAS_PROBE(somas::Cells, cells)
SOMAS_PROBE(somas::ClassInfo, class_info)
SOMAS_PROBE(somas::Connections, connections)
SOMAS_PROBE(somas::Controller, controller)
SOMAS_PROBE(somas::Declare, declare)
SOMAS_PROBE(somas::Environment, environment)
SOMAS_PROBE(somas::Extensible, extensible)
SOMAS_PROBE(somas::Fitness, fitness)
SOMAS_PROBE(somas::Genes, genes)
SOMAS_PROBE(somas::GenesView, genes_view)
SOMAS_PROBE(somas::Grid, grid)
SOMAS_PROBE(somas::GridSpec, grid_spec)
SOMAS_PROBE(somas::Heritable, heritable)
SOMAS_PROBE(somas::Host, host)
SOMAS_PROBE(somas::JsonReader, json_reader)
SOMAS_PROBE(somas::JsonWriter, json_writer)
SOMAS_PROBE(somas::Layout, layout)
SOMAS_PROBE(somas::Log, log)
SOMAS_PROBE(somas::LogLevel, log_level)
SOMAS_PROBE(somas::OnDivision, on_division)
SOMAS_PROBE(somas::Outcome, outcome)
SOMAS_PROBE(somas::ParameterError, parameter_error)
SOMAS_PROBE(somas::ParameterInfo, parameter_info)
SOMAS_PROBE(somas::ParameterKind, parameter_kind)
SOMAS_PROBE(somas::Matrix<float>, matrix)
SOMAS_PROBE(somas::Phase, phase)
SOMAS_PROBE(somas::PluginInfo, plugin_info)
SOMAS_PROBE(somas::PluginKind, plugin_kind)
SOMAS_PROBE(somas::PluginNote, plugin_note)
SOMAS_PROBE(somas::Point, point)
SOMAS_PROBE(somas::Port, port)
SOMAS_PROBE(somas::Program, program)
SOMAS_PROBE(somas::Relation, relation)
SOMAS_PROBE(somas::RelationKind, relation_kind)
SOMAS_PROBE(somas::Rng, rng)
SOMAS_PROBE(somas::Segment, segment)
SOMAS_PROBE(somas::SkillInfo, skill_info)
SOMAS_PROBE(somas::SkillSpec, skill_spec)
SOMAS_PROBE(somas::Specialization, specialization)
SOMAS_PROBE(somas::StateInfo, state_info)
SOMAS_PROBE(somas::StateSpec, state_spec)
SOMAS_PROBE(somas::Table, table)
SOMAS_PROBE(somas::TreeSink, tree_sink)
SOMAS_PROBE(somas::Value, value)
SOMAS_PROBE(somas::Variable, variable)
SOMAS_PROBE(somas::VariableSpec, variable_spec)
SOMAS_PROBE(somas::Workers, workers)
SOMAS_PROBE(somas::World, world)
SOMAS_PROBE(somas::WorldInfo, world_info)
SOMAS_PROBE(somas::PluginEntry, plugin_entry)

// Virtual tables are emitted where a class is made.
namespace {
class SomeFitness final : public somas::Fitness {
 public:
  std::string_view objective() const override { return ""; }
  double score(const somas::Outcome&) const override { return 0; }
};
}  // namespace
extern "C" __attribute__((visibility("default"))) void probe_made(somas::Fitness** made) {
  *made = new SomeFitness;
}
