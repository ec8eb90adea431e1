#pragma once

#include <vector>

#include "bus/accounts/ledger.hpp"

namespace bus::detail {

struct NodeCore;

// All accounts of the node: reliable classes from the book, LATEST from senders and receivers. With the mutex held.
std::vector<Account> AllAccounts(const NodeCore& core);

// Sums the accounts over all lives of each peer.
std::vector<Account> MergeByName(const std::vector<Account>& accounts);

// The part of `merged` between the present lives of both ends: what its writer sent, or what its reader has counted.
// False: no such account, or its ends do not count the same (SERVICE). With the mutex held.
bool FindPresentLife(const NodeCore& core, const std::vector<Account>& accounts, const Account& merged,
                     std::uint64_t* sent, std::uint64_t* peer_instance);

}  // namespace bus::detail
