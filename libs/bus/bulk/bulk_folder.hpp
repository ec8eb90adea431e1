#pragma once

#include <filesystem>
#include <string>

#include "bus/bulk/bulk.hpp"

namespace bus {

// Offers every file below a folder as "<name>/<path>", and then their list as "<name>". Errors: those of Offer(); the
// queue to the bus thread holds some sixty files.
core::Result<void> OfferFolder(const std::filesystem::path& folder, const std::string& name, BulkServer* server);

// Fetches what `owner` offers under that name into a folder; returns the number of files. A file that is present with
// the right content is not fetched. `node` is started and observes nothing else; `offers` reads bulk/<owner>.
core::Result<std::size_t> FetchFolder(Node* node, const StateReader<BulkOffer>& offers, const NodeOptions& options,
                                      const std::string& owner, const std::string& name,
                                      const std::filesystem::path& folder, std::int64_t timeout_ns);

}  // namespace bus
