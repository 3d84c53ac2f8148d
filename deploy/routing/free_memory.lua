-- Weighs the servers of the backend "place" by the memory and scenes that each daemon has left, as its /metrics tell: from
-- 1 (the daemon itself refuses, and says why) to 100 (empty, or the same share as the emptiest).

local BACKEND, PORT, PERIOD_MS = "place", 9464, 1000

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

local function room_of(server)
  local host = server:get_addr():match("^(.*):%d+$")
  local answer = core.httpclient():get{url = "http://" .. host .. ":" .. PORT .. "/metrics"}
  if answer.status ~= 200 then return nil end
  return room(answer.body)
end

local function weigh(servers)
  local rooms, most = {}, 0
  for name, server in pairs(servers) do
    local ok, bytes = pcall(room_of, server)
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
