#pragma once

#include <filesystem>
#include <string>

namespace powbench::host {

/// A browser that prints pages without a window: POWBENCH_BROWSER, else the first of chromium, chromium-browser,
/// google-chrome in PATH; "" = none.
std::string find_browser();

/// Prints an HTML page to PDF. Throws BadInput when there is no browser, StoreError when it fails or has written
/// nothing.
void print_pdf(const std::filesystem::path& html, const std::filesystem::path& pdf);

}  // namespace powbench::host
