#pragma once
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

/** What the exception says that a function throws; "no error": it throws none. */
template <class Function>
std::string message_of(const Function& function)
{
  try
  {
    function();
  }
  catch (const std::exception& e)
  {
    return e.what();
  }
  return "no error";
}

/** Whether a text has a part; a failure shows the text. */
inline testing::AssertionResult has(const std::string& text, const std::string& part)
{
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << part << "' is not in: " << text;
}
