#pragma once

#include <vector>

#include "bus/ledger.hpp"

namespace bus::detail {

struct NodeCore;

// All accounts of the node: the reliable classes from the book, LATEST from its senders and receivers. Mutex held.
std::vector<Account> AllAccounts(const NodeCore& core);

// All lives of a peer together.
std::vector<Account> MergeByName(const std::vector<Account>& accounts);

}  // namespace bus::detail
