#pragma once
// Numbers in files: the same text in every locale, with a decimal point and no groups of digits.
#include <optional>
#include <string>
#include <string_view>

namespace talus
{
/** Parses a whole text as a number: `-0.10`, `+2`, `1e-3`, also after blanks, `inf` and `nan`.
 * Empty for any other text, and for a number that a double cannot hold. */
std::optional<double> number_from(std::string_view text);

/** printf("%.*g") in the C locale, with at most `digits` significant digits. */
std::string number_text(double value, int digits = 10);

/** The shortest text of at least ten digits that reads back as the same number. */
std::string exact_number_text(double value);

/** printf("%.*f") in the C locale, with `decimals` digits after the point. */
std::string fixed_text(double value, int decimals);

}  // namespace talus
