#pragma once

#include <vector>

#include "bus/ledger.hpp"

namespace bus::detail {

struct NodeCore;

// All accounts of the node: the reliable classes from the book, LATEST from its senders and receivers. Mutex held.
std::vector<Account> AllAccounts(const NodeCore& core);

// All lives of a peer together.
std::vector<Account> MergeByName(const std::vector<Account>& accounts);

// What of `merged` was between the present lives of both ends alone: what its writer sent, or its reader knows of by
// its own count. False: there is no such account, or its ends do not count the same (SERVICE). Mutex held.
bool FindPresentLife(const NodeCore& core, const std::vector<Account>& accounts, const Account& merged,
                     std::uint64_t* sent, std::uint64_t* peer_instance);

}  // namespace bus::detail
