// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace tsg {

/// Where cores are scarce, other threads go before the calling one from now on. On Linux; elsewhere
/// it does nothing.
void lowerThreadPriority();

}  // namespace tsg
