// The replay page: one HTML file that holds the viewer (web/) and recorded lives.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace somas::report {

/// The page without recordings, as web/ builds it; compiled into the library.
[[nodiscard]] std::string_view page_template();

/// The page with these lives (PageData::bytes) side by side. The same lives give the same bytes.
/// Throws std::logic_error if the template has no place for them.
[[nodiscard]] std::string build_page(std::span<const std::string> lives);

}  // namespace somas::report
