#include "events.h"

#include <talus/text.h>

#include "bag_reader.h"

namespace talus::app
{
namespace
{
class BagEvents : public Events
{
 public:
  explicit BagEvents(const std::string& path) : reader_({path}, false)
  {
    std::vector<bool> wanted;
    for (const auto& topic : reader_.topics()) wanted.push_back(topic.encoding == "cdr");
    reader_.start(std::move(wanted));
  }
  bool next(Event& event) override
  {
    import::BagMessage message;
    if (!reader_.next(message)) return false;
    const auto& topic = reader_.topics()[message.topic];
    event = {
        static_cast<double>(message.log_time_ns) * 1e-9, topic.name, topic.type,
        ends_with(topic.name, "tf_static"), std::string(reader_.payload())};
    return true;
  }

 private:
  import::BagReader reader_;
};
}  // namespace

std::unique_ptr<Events> events_of_bag(const std::string& path)
{
  return std::make_unique<BagEvents>(path);
}

}  // namespace talus::app
