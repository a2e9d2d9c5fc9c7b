// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "task_scene_graph/config/visitor.h"

namespace tsg::nodelets {

/// Parameters that every stage has besides its own.
struct CommonConfig {
  double diagnostic_period = 1.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("diagnostic_period", self.diagnostic_period, {0.05, 60.0}, "s",
            "wall time between two messages on /diagnostics");
  }
};

}  // namespace tsg::nodelets
