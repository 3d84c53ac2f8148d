-- Weighs the servers of the backend "place" by the memory and scenes that each daemon has left, as its /metrics tell: from
-- 1 (the daemon itself refuses, and says why) to 100 (empty, or the same share as the emptiest).
-- METRICS_OF_DAEMONS in the environment names each server and where its daemon has /metrics: NAME=HOST:PORT, with spaces between.

local BACKEND, PERIOD_MS = "place", 1000

local metrics = {}
for name, address in os.getenv("METRICS_OF_DAEMONS"):gmatch("(%S+)=(%S+)") do
  metrics[name] = address
end

local function value(text, name)
  return tonumber(text:match("\n" .. name .. " (%S+)"))
end

local function free_share(text)
  local least = 1
  for used, limit in pairs({collided_device_bytes = "collided_max_device_bytes", collided_scenes = "collided_max_scenes"}) do
    least = math.min(least, 1 - value(text, used) / value(text, limit))
  end
  return least
end

-- Bytes, so that a daemon with twice the memory gets twice the scenes; 0 past the limit of scenes.
local function room(text)
  return math.max(0, free_share(text)) * value(text, "collided_max_device_bytes")
end

local function room_of(name)
  local answer = core.httpclient():get{url = "http://" .. metrics[name] .. "/metrics"}
  if answer.status ~= 200 then return nil end
  return room(answer.body)
end

local function weigh(servers)
  local rooms, most = {}, 0
  for name in pairs(servers) do
    local ok, bytes = pcall(room_of, name)
    if ok and bytes then
      rooms[name] = bytes
      most = math.max(most, bytes)
    end
  end
  for name, bytes in pairs(rooms) do
    servers[name]:set_weight(tostring(math.max(1, math.floor(100 * bytes / math.max(1, most) + 0.5))))
  end
end

core.register_task(function()
  while true do
    weigh(core.backends[BACKEND].servers)
    core.msleep(PERIOD_MS)
  end
end)
