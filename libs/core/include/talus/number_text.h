#pragma once
// Numbers in files: the same text in every locale that a host program may have set, with a decimal
// point and without groups of digits.
#include <optional>
#include <string>
#include <string_view>

namespace talus
{
/** The number that the whole text is, as people and programs write it: `-0.10`, `+2`, `1e-3`, with
 * blanks before it, `inf` and `nan` too. Nothing for any other text, and for a number that a double
 * cannot hold. */
std::optional<double> number_from(std::string_view text);

/** As printf("%.*g") of the C locale: with at most so many digits that count. */
std::string number_text(double value, int digits = 10);

/** In as few digits from ten on as give the same number again. */
std::string exact_number_text(double value);

/** As printf("%.*f") of the C locale: with so many digits behind the point. */
std::string fixed_text(double value, int decimals);

}  // namespace talus
