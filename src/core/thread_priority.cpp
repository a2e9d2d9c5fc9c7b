// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/core/thread_priority.h"

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace tsg {

void lowerThreadPriority() {
#ifdef __linux__
  constexpr int kNice = 5;
  setpriority(PRIO_PROCESS, 0, kNice);  // of this thread, on Linux
#endif
}

}  // namespace tsg
