// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace tsg {

/// The element whose `idOf` is `id` of a list that ascends by it; the list's end if there is none.
/// O(log size).
template <typename List, typename Id, typename IdOf>
typename List::const_iterator findById(const List& list, Id id, const IdOf& idOf) {
  const auto found = std::lower_bound(list.begin(), list.end(), id,
                                      [&](const auto& x, Id y) { return idOf(x) < y; });
  return found != list.end() && idOf(*found) == id ? found : list.end();
}

}  // namespace tsg
