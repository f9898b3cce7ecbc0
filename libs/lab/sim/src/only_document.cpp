#include "only_document.h"

#include <yaml-cpp/eventhandler.h>

#include <sstream>
#include <stdexcept>

namespace talus::sim
{
namespace
{
/** Notes where a document begins, and where it begins to say something. */
class Beginning : public YAML::EventHandler
{
 public:
  YAML::Mark start, content;
  bool is_empty = true;

  void OnDocumentStart(const YAML::Mark& mark) override
  {
    start = mark;
    is_empty = true;
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { note(mark); }
  void OnScalar(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override
  {
    note(mark);
  }
  void OnSequenceStart(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t,
      YAML::EmitterStyle::value) override
  {
    note(mark);
  }
  void OnMapStart(
      const YAML::Mark& mark, const std::string&, YAML::anchor_t,
      YAML::EmitterStyle::value) override
  {
    note(mark);
  }
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnDocumentEnd() override {}
  void OnSequenceEnd() override {}
  void OnMapEnd() override {}

 private:
  void note(const YAML::Mark& mark)
  {
    if (is_empty) content = mark;
    is_empty = false;
  }
};

}  // namespace

YAML::Node only_document(const std::string& text, const std::string& file)
{
  std::istringstream in(text);
  YAML::Parser parser(in);
  Beginning document;
  int last_start = -1;
  for (int number = 1; parser.HandleNextDocument(document); ++number)
  {
    // yaml-cpp takes a sign that begins nothing, such as ']', for an endless row of documents.
    if (document.start.pos == last_start)
      throw YAML::ParserException(document.start, "nothing begins so");
    last_start = document.start.pos;
    if (number > 1 && !document.is_empty)
      throw std::runtime_error(
          file + ":" + std::to_string(document.content.line + 1) +
          ": world: a second YAML document begins here; a file holds one world: remove it, or the "
          "'---' or '...' before it");
  }
  return YAML::Load(text);
}

}  // namespace talus::sim
