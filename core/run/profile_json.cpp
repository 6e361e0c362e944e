#include <nlohmann/json.hpp>
#include <springnet/run.hpp>
#include <springnet/version.hpp>

namespace springnet {

std::string to_json(const Profile& profile, std::uint64_t steps, unsigned threads) {
  using Json = nlohmann::ordered_json;
  const auto share = [&](double seconds) { return profile.seconds > 0.0 ? seconds / profile.seconds : 0.0; };
  std::vector<std::string> paths;
  Json stages = Json::array();
  for (const ProfileStage& stage : profile.stages) {
    const bool top = stage.parent < 0;
    paths.push_back((top ? "" : paths[static_cast<std::size_t>(stage.parent)] + "/") + label_of(stage));
    stages.push_back({{"path", paths.back()},
                      {"name", stage.name},
                      {"kind", name_of(stage.kind)},
                      {"parent", top ? Json(nullptr) : Json(stage.parent)},
                      {"share", share(stage.seconds)},
                      {"own_share", share(stage.own_seconds)},
                      {"seconds", stage.seconds},
                      {"own_seconds", stage.own_seconds},
                      {"calls", stage.calls},
                      {"estimated", stage.estimated}});
  }
  const Json document{
      {"seconds", profile.seconds}, {"steps", steps}, {"threads", threads}, {"stages", stages}, {"version", version()}};
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
