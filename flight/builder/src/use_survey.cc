#include <dn/builder/use_survey.h>

#include "factor_groups.h"

namespace dn {

void UseSurvey(const ControlNode& node, bool use, FlightNetwork* network) {
  Network& net = network->net();
  net.SetActive(node.survey, use);
  for (const std::size_t k : node.edges) {
    const FactorId id = network->control().edges()[k].id;
    const FactorRecord& record = net.factor(id);
    const bool plane = record.factor->residual_size() == 1;
    net.Tag(id, builder_internal::ControlReturnGroup(plane, use), record.t_s);
  }
}

}  // namespace dn
